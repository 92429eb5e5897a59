//! Requirements on a scene before rays may index it.

use crate::TraceError;
use rrf_scene::{INVALID, Scene};

/// Most triangles that leave room for the hierarchy's references.
const MOST_TRIANGLES: usize = 1 << 30;

/// Checks every length, id and coordinate.
pub(crate) fn check(scene: &Scene) -> Result<(), TraceError> {
    let triangles = scene.triangles.len();
    if triangles > MOST_TRIANGLES {
        return Err(TraceError::TooMany {
            count: triangles,
            limit: MOST_TRIANGLES,
        });
    }
    let parallel = [
        (
            "triangle_material",
            scene.triangle_material.len(),
            "triangles",
            triangles,
        ),
        (
            "triangle_light",
            scene.triangle_light.len(),
            "triangles",
            triangles,
        ),
        (
            "normals",
            scene.normals.len(),
            "positions",
            scene.positions.len(),
        ),
        ("uvs", scene.uvs.len(), "positions", scene.positions.len()),
    ];
    for (column, found, reference, expected) in parallel {
        if found != expected {
            return Err(TraceError::Length {
                column,
                found,
                reference,
                expected,
            });
        }
    }
    if let Some(vertex) = scene.positions.iter().position(|p| !p.is_finite()) {
        return Err(TraceError::NotFinite { vertex });
    }
    for (triangle, vertices) in scene.triangles.iter().enumerate() {
        let material = scene.triangle_material[triangle];
        let light = scene.triangle_light[triangle];
        let ids = [
            ("vertex", vertices[0], scene.positions.len()),
            ("vertex", vertices[1], scene.positions.len()),
            ("vertex", vertices[2], scene.positions.len()),
            ("material", material, scene.materials.len()),
            ("area light", light, scene.area_lights.len()),
        ];
        for (column, id, count) in ids {
            let absent = column == "area light" && id == INVALID;
            if !absent && id as usize >= count {
                return Err(TraceError::Id {
                    triangle,
                    column,
                    id,
                    count,
                });
            }
        }
    }
    for material in &scene.materials {
        for id in material.texture_ids() {
            if id != INVALID && id as usize >= scene.textures.len() {
                return Err(TraceError::TextureId {
                    material: material.name.clone(),
                    id,
                    count: scene.textures.len(),
                });
            }
        }
    }
    Ok(())
}
