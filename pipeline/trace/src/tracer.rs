//! A scene made ready for rays: checked once, then only indexed.

use crate::TraceError;
use glam::{Vec3, Vec3A};
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::ray::{Ray, RayHit};
use obvhs::triangle::Triangle;
use obvhs::{BvhBuildParams, bvh2};
use rrf_scene::{INVALID, Scene};
use std::time::Duration;

/// Rounding units by which a ray's origin is lifted off its triangle, times the largest
/// coordinate of the triangle. A point made from barycentrics is within about 5 units of its
/// plane, and the side test n.(v0 - o) of the intersection errs by about 10.
const LIFT: f32 = 32.0 * (0.5 * f32::EPSILON);

/// A scene's triangles in the order of a bounding volume hierarchy, with what a hit needs.
///
/// Slots are positions in BVH order; ids are the scene's own. Triangles without an area are
/// left out: they can neither be hit nor sampled.
pub struct Tracer<'s> {
    pub(crate) scene: &'s Scene,
    pub(crate) bvh: Bvh2,
    /// Corners in slot order.
    pub(crate) corners: Vec<Triangle>,
    /// Scene id of each slot.
    pub(crate) ids: Vec<u32>,
    /// Unit geometric normal of each scene triangle (zero where it has no area).
    pub(crate) normals: Vec<Vec3A>,
    /// Lift of ray origins off each scene triangle, in metres.
    pub(crate) lifts: Vec<f32>,
    /// Cumulative area of the scene's triangles, metres squared.
    pub(crate) area_cdf: Vec<f64>,
}

/// The closest triangle along a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Scene id of the triangle, or [`INVALID`] when nothing was hit.
    pub triangle: u32,
    /// Weights of the triangle's second and third corner.
    pub barycentrics: [f32; 2],
    /// Distance in units of the ray's direction; infinite when nothing was hit.
    pub t: f32,
}

impl Hit {
    /// Nothing along the ray.
    pub const MISS: Hit = Hit {
        triangle: INVALID,
        barycentrics: [0.0; 2],
        t: f32::INFINITY,
    };

    /// Whether something was hit.
    pub fn is_hit(&self) -> bool {
        self.triangle != INVALID
    }
}

impl<'s> Tracer<'s> {
    /// Checks every id and coordinate of the scene and builds the hierarchy.
    pub fn new(scene: &'s Scene) -> Result<Tracer<'s>, TraceError> {
        check(scene)?;
        let mut normals = Vec::with_capacity(scene.triangles.len());
        let mut lifts = Vec::with_capacity(scene.triangles.len());
        let mut area_cdf = Vec::with_capacity(scene.triangles.len());
        let (mut kept, mut corners, mut total) = (Vec::new(), Vec::new(), 0.0f64);
        for (id, triangle) in scene.triangles.iter().enumerate() {
            let [p0, p1, p2] = triangle.map(|v| scene.positions[v as usize]);
            let cross = (p1 - p0).as_dvec3().cross((p2 - p0).as_dvec3());
            let area = 0.5 * cross.length();
            let largest = p0.abs().max(p1.abs()).max(p2.abs()).max_element();
            total += area;
            area_cdf.push(total);
            normals.push(cross.normalize_or_zero().as_vec3().into());
            lifts.push(LIFT * largest.max(f32::MIN_POSITIVE));
            if area > 0.0 {
                kept.push(id as u32);
                corners.push(Triangle {
                    v0: p0.into(),
                    v1: p1.into(),
                    v2: p2.into(),
                });
            }
        }
        if corners.is_empty() {
            return Err(TraceError::NoTriangles);
        }
        let bvh = build(&corners);
        let slots = &bvh.primitive_indices;
        let ids = slots.iter().map(|&i| kept[i as usize]).collect();
        let corners = slots.iter().map(|&i| corners[i as usize]).collect();
        Ok(Tracer {
            scene,
            bvh,
            corners,
            ids,
            normals,
            lifts,
            area_cdf,
        })
    }

    /// The scene that is traced.
    pub fn scene(&self) -> &'s Scene {
        self.scene
    }

    /// The closest triangle with `0 <= t < t_max` along `origin + t direction`.
    #[inline]
    pub fn closest(&self, origin: Vec3, direction: Vec3, t_max: f32) -> Hit {
        let ray = Ray::new(origin.into(), direction.into(), 0.0, t_max);
        let mut found = RayHit::none();
        self.bvh.ray_traverse(ray, &mut found, |ray, slot| {
            self.corners[slot].intersect(ray)
        });
        let slot = found.primitive_id as usize;
        let Some(corners) = self.corners.get(slot) else {
            return Hit::MISS;
        };
        Hit {
            triangle: self.ids[slot],
            barycentrics: barycentrics(corners, &ray),
            t: found.t,
        }
    }

    /// Whether any triangle lies at `0 <= t < t_max` along `origin + t direction`.
    #[inline]
    pub fn occluded(&self, origin: Vec3, direction: Vec3, t_max: f32) -> bool {
        let ray = Ray::new(origin.into(), direction.into(), 0.0, t_max);
        !self
            .bvh
            .ray_traverse_miss(ray, |ray, slot| self.corners[slot].intersect(ray))
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

/// Weights of the second and third corner where the ray meets the triangle's plane
/// (Moeller and Trumbore 1997), kept inside the triangle against rounding.
#[inline(always)]
fn barycentrics(triangle: &Triangle, ray: &Ray) -> [f32; 2] {
    let (e1, e2) = (triangle.v1 - triangle.v0, triangle.v2 - triangle.v0);
    let to = ray.origin - triangle.v0;
    let p = ray.direction.cross(e2);
    let inverse = 1.0 / e1.dot(p);
    let b1 = (to.dot(p) * inverse).clamp(0.0, 1.0);
    let b2 = ray.direction.dot(to.cross(e1)) * inverse;
    [b1, b2.clamp(0.0, 1.0 - b1)]
}

fn build(corners: &[Triangle]) -> Bvh2 {
    let parameters = BvhBuildParams {
        // A split triangle would stand in several slots.
        pre_split: false,
        ..BvhBuildParams::slow_build()
    };
    build_bvh2_from_tris(corners, parameters, &mut Duration::default())
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
