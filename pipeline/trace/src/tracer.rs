//! A scene made ready for rays: checked once, then only indexed.

use crate::TraceError;
use crate::lamps::Lamps;
use crate::rays::{self, Hits, Rays};
use crate::surface::doubled_area;
use crate::wide::Wide;
use glam::{Vec3, Vec3A};
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::triangle::Triangle;
use obvhs::{BvhBuildParams, bvh2};
use rrf_scene::{INVALID, MaterialKind, Scene};
use std::time::Duration;

/// Rounding units by which a ray's origin is lifted off its triangle, times the largest
/// coordinate of the triangle. A point made from barycentrics is within about 5 units of its
/// plane, and the side test n.(v0 - o) of the intersection errs by about 10.
const LIFT: f32 = 32.0 * (0.5 * f32::EPSILON);

/// A scene with a hierarchy over its triangles and what hits and samples need at hand.
///
/// Triangles without an area are left out: they can neither be hit nor sampled.
pub struct Tracer<'s> {
    pub(crate) scene: &'s Scene,
    /// The binary tree, for searches by place; its primitives index `kept`.
    pub(crate) bvh: Bvh2,
    /// Scene ids of the triangles in the hierarchy.
    pub(crate) kept: Vec<u32>,
    /// The same tree, eight wide, for rays.
    pub(crate) wide: Wide,
    /// Whether any material is not Lambert.
    pub(crate) mixed: bool,
    /// Triangles whose shading normal is the geometric one everywhere.
    pub(crate) flat: Vec<bool>,
    /// Unit geometric normal of each scene triangle (zero where it has no area).
    pub(crate) normals: Vec<Vec3A>,
    /// Lift of ray origins off each scene triangle, in metres.
    pub(crate) lifts: Vec<f32>,
    /// Cumulative area of the scene's triangles, metres squared.
    pub(crate) area_cdf: Vec<f64>,
    /// The triangles that emit.
    pub(crate) lamps: Lamps,
}

impl<'s> Tracer<'s> {
    /// Checks every id and coordinate of the scene and builds the hierarchy.
    pub fn new(scene: &'s Scene) -> Result<Tracer<'s>, TraceError> {
        check(scene)?;
        let count = scene.triangles.len();
        let mut normals = Vec::with_capacity(count);
        let mut lifts = Vec::with_capacity(count);
        let mut area_cdf = Vec::with_capacity(count);
        let (mut kept, mut corners, mut total) = (Vec::new(), Vec::new(), 0.0f64);
        for (id, triangle) in scene.triangles.iter().enumerate() {
            let points = triangle.map(|v| scene.positions[v as usize]);
            let [p0, p1, p2] = points;
            let cross = doubled_area(points);
            let area = 0.5 * cross.length();
            let largest = p0.abs().max(p1.abs()).max(p2.abs()).max_element();
            total += area;
            area_cdf.push(total);
            normals.push(Vec3A::from(cross.normalize_or_zero().as_vec3()));
            lifts.push(LIFT * largest.max(f32::MIN_POSITIVE));
            if area > 0.0 {
                kept.push(id as u32);
                corners.push(points);
            }
        }
        if kept.is_empty() {
            return Err(TraceError::NoTriangles);
        }
        let flat = (0..count)
            .map(|t| is_flat(scene, t, normals[t].into()))
            .collect();
        let bvh = build(&corners);
        Ok(Tracer {
            scene,
            wide: Wide::new(&bvh, &corners, &kept),
            bvh,
            kept,
            mixed: scene
                .materials
                .iter()
                .any(|m| m.kind != MaterialKind::Lambert),
            flat,
            normals,
            lifts,
            lamps: Lamps::new(scene, &area_cdf),
            area_cdf,
        })
    }

    /// The scene that is traced.
    pub fn scene(&self) -> &'s Scene {
        self.scene
    }

    /// The closest triangle of every ray, into `hits`.
    pub fn closest(&self, rays: &Rays, hits: &mut Hits) {
        rays::closest(&self.wide, rays, &mut self.wide.stack(), hits);
    }

    /// Whether anything lies along each ray, into `blocked`.
    pub fn occluded(&self, rays: &Rays, blocked: &mut Vec<bool>) {
        rays::occluded(&self.wide, rays, &mut self.wide.stack(), blocked);
    }

    /// A ray's origin just off a triangle, on the side that `direction` leaves to.
    #[inline]
    pub fn lift(&self, triangle: u32, position: Vec3, direction: Vec3) -> Vec3 {
        let normal = Vec3::from(self.normals[triangle as usize]);
        let side = if normal.dot(direction) < 0.0 {
            -1.0
        } else {
            1.0
        };
        position + normal * (side * self.lifts[triangle as usize])
    }
}

fn build(corners: &[[Vec3; 3]]) -> Bvh2 {
    let triangles: Vec<Triangle> = corners
        .iter()
        .map(|&[v0, v1, v2]| Triangle {
            v0: v0.into(),
            v1: v1.into(),
            v2: v2.into(),
        })
        .collect();
    let parameters = BvhBuildParams {
        // A split triangle would stand in several leaves.
        pre_split: false,
        // The collapse to eight children chooses the leaves.
        max_prims_per_leaf: 1,
        ..BvhBuildParams::slow_build()
    };
    build_bvh2_from_tris(&triangles, parameters, &mut Duration::default())
}

/// Whether the corners of a triangle have no normals or, to rounding, its own, and nothing
/// bends them.
fn is_flat(scene: &Scene, triangle: usize, normal: Vec3) -> bool {
    let none = scene.triangles[triangle]
        .iter()
        .all(|&v| scene.normals[v as usize] == Vec3::ZERO);
    let own = scene.triangles[triangle].iter().all(|&v| {
        let n = scene.normals[v as usize].normalize_or_zero();
        n.cross(normal).length() < 1e-6 && n != Vec3::ZERO
    });
    let material = &scene.materials[scene.triangle_material[triangle] as usize];
    material.normal_texture == INVALID && (none || own)
}

fn check(scene: &Scene) -> Result<(), TraceError> {
    let triangles = scene.triangles.len();
    let limit = (bvh2::DEFAULT_MAX_STACK_DEPTH << 24).min(1 << 30);
    if triangles > limit {
        return Err(TraceError::TooMany {
            count: triangles,
            limit,
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
        let used = [
            material.base_texture,
            material.roughness_metallic_texture,
            material.normal_texture,
        ];
        for id in used {
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
