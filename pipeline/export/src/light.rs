//! Lights that are no surface as Mitsuba 3's emitters.

use crate::{ExportError, material};
use rrf_scene::{LightSource, PointLight, Scene};
use std::path::Path;

/// The scene's own lights, their pictures written beside, and points besides. Adds to `notes` how
/// Mitsuba's lights differ.
pub(crate) fn emitters(
    folder: &Path,
    scene: &Scene,
    points: &[PointLight],
    notes: &mut Vec<String>,
) -> Result<String, ExportError> {
    let mut xml = String::new();
    let mut skies = 0;
    for (number, light) in scene.lights.iter().enumerate() {
        let file = format!("textures/light{number}.exr");
        let written = light.source.mitsuba(&file);
        if let Some(picture) = written.picture {
            material::write_texels(&folder.join(&file), &picture)?;
        }
        let noted = written.note;
        notes.extend(noted.map(|note| format!("light {:?}: {note}", light.name)));
        skies += usize::from(light.source.is_sky());
        xml += &written.xml;
    }
    if skies > 1 {
        notes.push(format!("{skies} skies; Mitsuba allows for one"));
    }
    for &point in points {
        xml += &LightSource::Point(point).mitsuba("").xml;
    }
    Ok(xml)
}

/// The emitter of an area light's shapes, its picture written beside; empty for no light.
pub(crate) fn area(folder: &Path, scene: &Scene, id: u32) -> Result<String, ExportError> {
    let Some(light) = scene.area_lights.get(id as usize) else {
        return Ok(String::new());
    };
    let radiance = match scene.emission_texture(id) {
        Some(picture) => {
            let file = format!("textures/lamp{id}.exr");
            material::write_rgb(&folder.join(&file), picture, light.radiance)?;
            material::bitmap("radiance", &file, false)
        }
        None => material::rgb("radiance", light.radiance),
    };
    Ok(format!("<emitter type=\"area\">\n{radiance}</emitter>\n"))
}
