//! Wavefront OBJ with its MTL libraries.
//!
//! `tobj` parses the numbers, merges the vertices and triangulates. It reads lines of more
//! than two points as faces, misplaces texture coordinates when only some faces have them,
//! panics on `Kd 1` and names no line in its errors; so [`scan`] looks over the text first
//! and [`mtl`] reads the libraries.
//!
//! Sources: Wavefront, Advanced Visualizer manual, appendix B1 (object files); the PBR
//! extension of MTL (Pr, Pm, norm) by Exocortex.

mod lines;
mod material;
mod mtl;
mod scan;

use crate::warn::Warnings;
use crate::{AreaLight, INVALID, LoadOptions, Scene, SceneError};
use glam::{Vec2, Vec3};
use material::Materials;
use scan::Scan;
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
    let scan = scan::scan(path, &String::from_utf8_lossy(&bytes), &mut warnings)?;
    let mut materials = Materials::read(path, &scan, options, &mut warnings)?;
    let mut scene = Scene {
        source: path.to_path_buf(),
        ..Scene::default()
    };
    for model in parse(path, &scan, &materials)? {
        append(&model, &mut materials, &mut scene, &mut warnings);
    }
    materials.finish(&mut scene, &mut warnings);
    scene.warnings = warnings.finish();
    Ok(scene)
}

/// `tobj` over the scanned text: a model for each object, group or change of material.
fn parse(path: &Path, scan: &Scan, materials: &Materials) -> Result<Vec<tobj::Model>, SceneError> {
    let mut reader = scan.reader();
    let names = |_: &Path| {
        let named = |name: &str| tobj::Material {
            name: name.into(),
            ..tobj::Material::default()
        };
        let ids = materials.names().enumerate();
        Ok((
            materials.names().map(named).collect(),
            ids.map(|(id, name)| (name.to_owned(), id)).collect(),
        ))
    };
    let options = tobj::LoadOptions {
        single_index: true,
        triangulate: true,
        ..tobj::LoadOptions::default()
    };
    let parsed = tobj::load_obj_buf(&mut reader, &options, names);
    let line = reader.line();
    parsed
        .map(|(models, _)| models)
        .map_err(|error| SceneError::Syntax {
            path: path.to_path_buf(),
            line,
            column: 1,
            message: error.to_string(),
        })
}

/// Adds a model's vertices and triangles.
fn append(
    model: &tobj::Model,
    materials: &mut Materials,
    scene: &mut Scene,
    warnings: &mut Warnings,
) {
    let mesh = &model.mesh;
    if mesh.indices.is_empty() {
        return;
    }
    let first = scene.positions.len();
    let (positions, _) = mesh.positions.as_chunks::<3>();
    let positions = positions.iter().copied().map(Vec3::from_array);
    scene.positions.extend(positions);
    let (normals, _) = mesh.normals.as_chunks::<3>();
    let normals = normals.iter().copied().map(Vec3::from_array);
    scene.normals.extend(normals);
    // v grows upwards in OBJ, as in ours.
    let (uvs, _) = mesh.texcoords.as_chunks::<2>();
    scene.uvs.extend(uvs.iter().copied().map(Vec2::from_array));
    let count = scene.positions.len();
    scene.normals.resize(count, Vec3::ZERO);
    scene.uvs.resize(count, Vec2::ZERO);
    append_triangles(model, materials, scene, first as u32, warnings);
}

fn append_triangles(
    model: &tobj::Model,
    materials: &mut Materials,
    scene: &mut Scene,
    first: u32,
    warnings: &mut Warnings,
) {
    let (triangles, _) = model.mesh.indices.as_chunks::<3>();
    let used = materials.of_model(model, triangles.len(), warnings);
    if used.is_textured && model.mesh.texcoords.is_empty() {
        let message = "textured, but without vt: one texel for all";
        warnings.add(format!("object {:?}", model.name), message);
    }
    let moved = triangles.iter().map(|t| t.map(|vertex| first + vertex));
    scene.triangles.extend(moved);
    let count = scene.triangles.len();
    let light = if used.radiance == Vec3::ZERO {
        INVALID
    } else {
        scene.area_lights.push(AreaLight {
            radiance: used.radiance,
            two_sided: false,
        });
        scene.area_lights.len() as u32 - 1
    };
    let object = scene.objects.len() as u32;
    scene.triangle_material.resize(count, used.id);
    scene.triangle_light.resize(count, light);
    scene.triangle_object.resize(count, object);
    scene.objects.push(model.name.clone());
}
