//! Triangles of one shape on their way from object space to the scene's columns.

use super::fault::{Place, Read, fault};
use super::transform::{normal_matrix, swaps_handedness};
use super::value::Mapping;
use crate::INVALID;
use glam::{DMat4, DVec2, DVec3, Vec2, Vec3};

/// Most triangles of a scene, instances counted each time; vertices may be three times as many.
pub(super) const MAX_TRIANGLES: usize = 1 << 25;

/// A shape in its object space.
#[derive(Debug, Default)]
pub(super) struct Local {
    pub positions: Vec<DVec3>,
    /// One a vertex, or empty.
    pub normals: Vec<DVec3>,
    /// One a vertex, or empty.
    pub uvs: Vec<DVec2>,
    /// Ids in range.
    pub triangles: Vec<[u32; 3]>,
    /// `ReverseOrientation` turns the normals too: quadrics always, meshes in version 4.
    pub reverse_normals: bool,
}

/// Area lights of a mesh's triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Lights {
    None,
    /// All triangles belong to one light.
    One(u32),
    /// Triangle i is light first + i.
    Each(u32),
}

/// A shape in world space (or in its object's), wound so that (p1-p0) x (p2-p0) is pbrt's
/// surface normal.
#[derive(Clone, Debug)]
pub(super) struct Mesh {
    pub name: String,
    pub positions: Vec<Vec3>,
    /// One a vertex.
    pub normals: Vec<Vec3>,
    /// One a vertex.
    pub uvs: Vec<Vec2>,
    pub triangles: Vec<[u32; 3]>,
    pub material: u32,
    pub lights: Lights,
}

/// The corners of a triangle with ids in range.
fn corners<T: Copy + Default>(column: &[T], triangle: [u32; 3]) -> [T; 3] {
    triangle.map(|i| column.get(i as usize).copied().unwrap_or_default())
}

impl Local {
    /// Gives each triangle vertices of its own and pbrt's texture coordinates for shapes
    /// that have none: (0,0), (1,0), (1,1).
    pub fn with_default_uvs(self) -> Self {
        let flat = |column: &[DVec3]| {
            self.triangles
                .iter()
                .flat_map(|&triangle| corners(column, triangle))
                .collect::<Vec<_>>()
        };
        let count = self.triangles.len() as u32;
        Self {
            positions: flat(&self.positions),
            normals: if self.normals.is_empty() {
                Vec::new()
            } else {
                flat(&self.normals)
            },
            uvs: (0..count)
                .flat_map(|_| [DVec2::ZERO, DVec2::X, DVec2::ONE])
                .collect(),
            triangles: (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
            reverse_normals: self.reverse_normals,
        }
    }

    /// Applies a texture's mapping of (u, v).
    pub fn map_uvs(&mut self, map: &Mapping) {
        for uv in &mut self.uvs {
            *uv = *uv * map.scale + map.offset;
        }
    }

    /// Moves the shape into the world and winds its triangles as pbrt orients its normals:
    /// towards the vertex normals where there are any (per triangle, their sum), else by
    /// `ReverseOrientation` and the transform's handedness.
    pub fn placed(self, ctm: &DMat4, reverse: bool, name: String, place: Place) -> Read<Mesh> {
        let Some(to_normals) = normal_matrix(ctm) else {
            return fault(
                place,
                "the transform flattens this shape: its determinant is 0",
            );
        };
        let turn = if reverse && self.reverse_normals {
            -1.0
        } else {
            1.0
        };
        let positions: Vec<DVec3> = self
            .positions
            .iter()
            .map(|&p| ctm.transform_point3(p))
            .collect();
        let normals: Vec<DVec3> = self
            .normals
            .iter()
            .map(|&n| {
                (to_normals * n)
                    .try_normalize()
                    .map_or(DVec3::ZERO, |n| n * turn)
            })
            .collect();
        let flip_without_normals = reverse != swaps_handedness(ctm);
        let mut triangles = self.triangles;
        for triangle in &mut triangles {
            let [p0, p1, p2] = corners(&positions, *triangle);
            let shading: DVec3 = corners(&normals, *triangle).iter().sum();
            let along = (p1 - p0).cross(p2 - p0).dot(shading);
            if along < 0.0 || (along == 0.0 && flip_without_normals) {
                triangle.swap(1, 2);
            }
        }
        let positions: Vec<Vec3> = positions.iter().map(|v| v.as_vec3()).collect();
        if !positions.iter().all(|p| p.is_finite()) {
            return fault(place, "a position of this shape is beyond single precision");
        }
        Ok(Mesh {
            name,
            normals: if normals.is_empty() {
                vec![Vec3::ZERO; positions.len()]
            } else {
                normals.iter().map(|v| v.as_vec3()).collect()
            },
            uvs: if self.uvs.is_empty() {
                vec![Vec2::ZERO; positions.len()]
            } else {
                self.uvs.iter().map(|v| v.as_vec2()).collect()
            },
            positions,
            triangles,
            material: INVALID,
            lights: Lights::None,
        })
    }
}

impl Mesh {
    /// The mesh under one more transform; its outside stays its outside.
    pub fn transformed(&self, m: &DMat4, place: Place) -> Read<Mesh> {
        let Some(to_normals) = normal_matrix(m) else {
            return fault(
                place,
                "the transform flattens this instance: its determinant is 0",
            );
        };
        let mut mesh = self.clone();
        for p in &mut mesh.positions {
            *p = m.transform_point3(p.as_dvec3()).as_vec3();
        }
        if !mesh.positions.iter().all(|p| p.is_finite()) {
            return fault(
                place,
                "a position of this instance is beyond single precision",
            );
        }
        for n in &mut mesh.normals {
            *n = (to_normals * n.as_dvec3()).normalize_or_zero().as_vec3();
        }
        if swaps_handedness(m) {
            for triangle in &mut mesh.triangles {
                triangle.swap(1, 2);
            }
        }
        Ok(mesh)
    }

    /// The area of a triangle.
    pub fn area(&self, triangle: [u32; 3]) -> f64 {
        let [p0, p1, p2] = corners(&self.positions, triangle).map(|p| p.as_dvec3());
        0.5 * (p1 - p0).cross(p2 - p0).length()
    }
}
