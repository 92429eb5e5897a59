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
        skies += usize::from(matches!(light.source, LightSource::Environment(_)));
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
