//! Wavefront OBJ with its MTL libraries.
//!
//! [`parse`] reads the statements, [`mtl`] and [`material`] the libraries; models become columns
//! here, with one vertex for each combination of position, texture coordinate and normal.
//!
//! Sources: Wavefront, Advanced Visualizer manual, appendix B1 (object files); the PBR
//! extension of MTL (Pr, Pm, norm) by Exocortex.

mod library;
mod lines;
mod material;
mod model;
mod mtl;
mod parse;

use crate::own_lights::LampNames;
use crate::warn::Warnings;
use crate::{AreaLight, INVALID, LoadOptions, Scene, SceneError};
use glam::Vec3;
use material::Materials;
use model::{Corner, Model, Obj};
use std::collections::HashMap;
use std::path::Path;

/// Reads an `.obj` file.
pub(crate) fn read(path: &Path, options: &LoadOptions) -> Result<Scene, SceneError> {
    let bytes = crate::file::read_bytes(path)?;
    // Every line and every corner of a face takes a byte or more: with this, all counts fit.
    if bytes.len() >= INVALID as usize {
        return Err(SceneError::Content {
            path: path.to_path_buf(),
            place: "file".into(),
            message: "4 GiB or more; divide it".into(),
        });
    }
    let mut warnings = Warnings::default();
    let obj = parse::parse(path, &crate::file::text(&bytes), &mut warnings)?;
    let mut materials = Materials::read(path, &obj, options, &mut warnings)?;
    let mut scene = Scene {
        source: path.to_path_buf(),
        ..Scene::default()
    };
    let models = &obj.models;
    let same = |a: &Model, b: &Model| b.continues && materials.agree(a, b);
    let groups: Vec<&[Model]> = models.chunk_by(same).collect();
    let mut names = LampNames::default();
    for models in groups {
        append(
            &obj,
            models,
            &mut materials,
            &mut names,
            &mut scene,
            &mut warnings,
        );
    }
    materials.finish(&mut scene, &mut warnings);
    scene.warnings = warnings.finish();
    Ok(scene)
}

/// Adds the vertices of models that are one, in the order of their first corners, and the triangles.
fn append(
    obj: &Obj,
    models: &[Model],
    materials: &mut Materials,
    names: &mut LampNames,
    scene: &mut Scene,
    warnings: &mut Warnings,
) {
    let triangles: Vec<_> = models.iter().flat_map(|model| &model.triangles).collect();
    let (Some(model), false) = (models.first(), triangles.is_empty()) else {
        return;
    };
    let used = materials.of_model(model, triangles.len(), warnings);
    let mut ids: HashMap<Corner, u32> = HashMap::new();
    let mut has_uvs = false;
    for triangle in triangles {
        let triangle = triangle.map(|corner| {
            *ids.entry(corner).or_insert_with(|| {
                let [position, uv, normal] = corner.map(|id| id.unwrap_or(INVALID) as usize);
                has_uvs |= corner[1].is_some();
                // v grows upwards in OBJ, as in ours.
                let columns = (
                    obj.positions.get(position),
                    obj.uvs.get(uv),
                    obj.normals.get(normal),
                );
                scene.positions.push(columns.0.copied().unwrap_or_default());
                scene.uvs.push(columns.1.copied().unwrap_or_default());
                scene.normals.push(columns.2.copied().unwrap_or_default());
                scene.positions.len() as u32 - 1
            })
        });
        scene.triangles.push(triangle);
    }
    if used.is_textured && !has_uvs {
        let message = "textured, but without vt: one texel for all";
        warnings.add(format!("object {:?}", model.name), message);
    }
    let count = scene.triangles.len();
    let light = if used.radiance == Vec3::ZERO {
        INVALID
    } else {
        let light = AreaLight {
            radiance: used.radiance,
            two_sided: false,
        };
        let name = names.of_material(used.id, materials.name(used.id));
        scene.add_area_light(light, name, used.emission_texture)
    };
    let object = scene.objects.len() as u32;
    scene.triangle_material.resize(count, used.id);
    scene.triangle_light.resize(count, light);
    scene.triangle_object.resize(count, object);
    scene.objects.push(model.name.clone());
}
