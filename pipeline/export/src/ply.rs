//! Meshes as binary PLY (Turk 1994), as Mitsuba 3 reads them.

use crate::ExportError;
use crate::error::write_file;
use rrf_scene::Scene;
use std::collections::HashMap;
use std::path::Path;

/// Triangles that share an object, a material, a light and a kind of normals.
pub(crate) struct Mesh {
    pub(crate) triangles: Vec<u32>,
    pub(crate) material: u32,
    pub(crate) light: u32,
    /// Vertices carry normals; otherwise each triangle has its own.
    pub(crate) smooth: bool,
}

/// The scene's meshes in the order of their first triangles.
pub(crate) fn meshes(scene: &Scene) -> Vec<Mesh> {
    let mut places = HashMap::new();
    let mut meshes: Vec<Mesh> = Vec::new();
    for (t, corners) in scene.triangles.iter().enumerate() {
        let smooth = corners
            .iter()
            .any(|&v| scene.normals[v as usize] != glam::Vec3::ZERO);
        let (material, light) = (scene.triangle_material[t], scene.triangle_light[t]);
        let key = (scene.triangle_object[t], material, light, smooth);
        let place = *places.entry(key).or_insert_with(|| {
            meshes.push(Mesh {
                triangles: Vec::new(),
                material,
                light,
                smooth,
            });
            meshes.len() - 1
        });
        meshes[place].triangles.push(t as u32);
    }
    meshes
}

/// Writes one mesh: positions in metres, normals where smooth, texture coordinates with t
/// growing downwards (Mitsuba's row 0 of a picture is at t = 0, the scene's at v = 1).
pub(crate) fn write(path: &Path, scene: &Scene, mesh: &Mesh) -> Result<(), ExportError> {
    let mut places: HashMap<u32, u32> = HashMap::new();
    let mut vertices = Vec::new();
    let mut faces = Vec::new();
    for &t in &mesh.triangles {
        faces.push(3);
        for v in scene.triangles[t as usize] {
            let next = places.len() as u32;
            let place = *places.entry(v).or_insert(next);
            if place == next {
                push_vertex(scene, v as usize, mesh.smooth, &mut vertices);
            }
            faces.extend(place.to_le_bytes());
        }
    }
    let normals = if mesh.smooth {
        "property float nx\nproperty float ny\nproperty float nz\n"
    } else {
        ""
    };
    let header = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\n\
         property float x\nproperty float y\nproperty float z\n{normals}\
         property float s\nproperty float t\nelement face {}\n\
         property list uchar uint vertex_indices\nend_header\n",
        places.len(),
        mesh.triangles.len()
    );
    let bytes = [header.into_bytes(), vertices, faces].concat();
    write_file(path, &bytes)
}

fn push_vertex(scene: &Scene, v: usize, smooth: bool, to: &mut Vec<u8>) {
    let normal = scene.normals[v].to_array();
    let uv = scene.uvs[v];
    let numbers = scene.positions[v].to_array().into_iter();
    let numbers = numbers.chain(normal.into_iter().filter(|_| smooth));
    to.extend(numbers.chain([uv.x, 1.0 - uv.y]).flat_map(f32::to_le_bytes));
}
