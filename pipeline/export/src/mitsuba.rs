//! A scene as a folder that Mitsuba 3 loads: `scene.xml`, `meshes/*.ply`, `textures/*.exr`.
//!
//! The materials are Mitsuba's own by definition (`diffuse`, `principled` with base colour,
//! roughness, metallic and specular, both in `twosided`), so that a frame of the exported scene
//! agrees with `rrf trace` within noise. What cannot be said in Mitsuba's terms is returned as
//! notes.

use crate::error::write_file;
use crate::{ExportError, light, material, ply};
use glam::Vec3;
use rrf_scene::{Camera, INVALID, PointLight, Scene};
use std::fmt::Write as _;
use std::path::Path;

/// Paths a pixel that the exported scene asks for; a renderer's command line can say otherwise.
const SAMPLES: u32 = 256;

/// Writes the scene, seen by `camera` (if there is one) and lit by `points` beside its own lights.
/// Returns what was approximated.
///
/// # Errors
/// [`ExportError::Write`].
pub fn write_mitsuba(
    folder: &Path,
    scene: &Scene,
    camera: Option<&Camera>,
    points: &[PointLight],
) -> Result<Vec<String>, ExportError> {
    for part in ["meshes", "textures"] {
        let part = folder.join(part);
        rrf_files::make_folder(&part).map_err(|source| ExportError::Write {
            path: part.clone(),
            source,
        })?;
    }
    let mut xml = String::from(HEAD);
    if let Some(camera) = camera {
        xml += &sensor(camera, scene);
    }
    for id in 0..scene.materials.len() {
        xml += &material::bsdf(folder, scene, id)?;
    }
    let mut notes = notes(scene);
    xml += &light::emitters(folder, scene, points, &mut notes)?;
    for (number, mesh) in ply::meshes(scene).iter().enumerate() {
        let file = format!("meshes/{number:04}.ply");
        ply::write(&folder.join(&file), scene, mesh)?;
        xml += &shape(folder, &file, scene, mesh)?;
    }
    xml += "</scene>\n";
    let path = folder.join("scene.xml");
    write_file(&path, xml.as_bytes())?;
    Ok(notes)
}

const HEAD: &str = "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n\
    <!-- Metres (scene units), W/sr, W/(sr m^2); linear sRGB. Written by rrf export. -->\n\
    <scene version=\"3.0.0\">\n\
    <integrator type=\"path\">\n<integer name=\"max_depth\" value=\"-1\"/>\n</integrator>\n";

/// The pinhole camera with a box filter, as `rrf trace` averages a pixel. Mitsuba's camera looks
/// along its z with x to the left.
fn sensor(camera: &Camera, scene: &Scene) -> String {
    let bounds = scene.bounds();
    let corners = bounds.map_or([Vec3::ZERO, Vec3::ONE], |b| [b.min.into(), b.max.into()]);
    let size = corners[0].distance(corners[1]);
    let far = camera.eye.distance(corners[0]) + size;
    let (left, up, forward, eye) = (-camera.right, camera.up, camera.forward, camera.eye);
    let mut matrix = String::new();
    for row in 0..3 {
        let _ = write!(
            matrix,
            "{} {} {} {} ",
            left[row], up[row], forward[row], eye[row]
        );
    }
    format!(
        "<sensor type=\"perspective\">\n<string name=\"fov_axis\" value=\"smaller\"/>\n\
         <float name=\"fov\" value=\"{}\"/>\n<float name=\"near_clip\" value=\"{}\"/>\n\
         <float name=\"far_clip\" value=\"{far}\"/>\n\
         <transform name=\"to_world\">\n<matrix value=\"{matrix}0 0 0 1\"/>\n</transform>\n\
         <sampler type=\"independent\">\n<integer name=\"sample_count\" value=\"{SAMPLES}\"/>\n\
         </sampler>\n<film type=\"hdrfilm\">\n<integer name=\"width\" value=\"{}\"/>\n\
         <integer name=\"height\" value=\"{}\"/>\n\
         <string name=\"pixel_format\" value=\"rgb\"/>\n\
         <string name=\"component_format\" value=\"float32\"/>\n\
         <rfilter type=\"box\"/>\n</film>\n</sensor>\n",
        camera.fov,
        1e-5 * size,
        camera.width,
        camera.height
    )
}

fn shape(
    folder: &Path,
    file: &str,
    scene: &Scene,
    mesh: &ply::Mesh,
) -> Result<String, ExportError> {
    let normals = if mesh.smooth {
        ""
    } else {
        "<boolean name=\"face_normals\" value=\"true\"/>\n"
    };
    let emitter = light::area(folder, scene, mesh.light)?;
    Ok(format!(
        "<shape type=\"ply\">\n<string name=\"filename\" value=\"{file}\"/>\n{normals}\
         <ref id=\"m{}\"/>\n{emitter}</shape>\n",
        mesh.material
    ))
}

/// Notes on what Mitsuba will do otherwise.
fn notes(scene: &Scene) -> Vec<String> {
    let mut notes = Vec::new();
    let used = |light: usize| scene.triangle_light.contains(&(light as u32));
    let both = (scene.area_lights.iter().enumerate())
        .filter(|(id, light)| light.two_sided && used(*id))
        .count();
    if both > 0 {
        notes.push(format!(
            "{both} area lights shine from both sides; Mitsuba's shine from the front alone"
        ));
    }
    let bent = (scene.materials.iter())
        .filter(|m| m.normal_texture != INVALID)
        .count();
    if bent > 0 {
        notes.push(format!(
            "{bent} materials have normal maps; on surfaces whose texture is mirrored Mitsuba \
             bends them the other way along v"
        ));
    }
    notes
}
