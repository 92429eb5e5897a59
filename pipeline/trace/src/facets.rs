//! Triangles as hits and samples need them: geometry and material side by side.

use glam::{DVec3, Vec3};
use rrf_materials::{Bsdf, INVALID, Material};
use rrf_scene::Scene;

/// Rounding units by which a ray's origin is lifted off its triangle, times the largest
/// coordinate of the triangle. A point made from barycentrics is within about 5 units of its
/// plane, and the plane's distance in an intersection errs by about 10.
const LIFT: f32 = 32.0 * (0.5 * f32::EPSILON);

/// One triangle of the scene.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Facet {
    /// First corner and the edges to the others.
    pub(crate) corner: Vec3,
    pub(crate) edges: [Vec3; 2],
    /// Unit geometric normal; zero where the triangle has no area.
    pub(crate) normal: Vec3,
    /// Lift of ray origins off the triangle, metres.
    pub(crate) lift: f32,
    pub(crate) material: u32,
    /// Whether the shading normal differs from the geometric one anywhere.
    pub(crate) smooth: bool,
    /// Whether the material differs from its constants anywhere.
    pub(crate) textured: bool,
    /// Whether it encloses a solid that light travels in.
    pub(crate) encloses: bool,
    /// Whether light goes straight through somewhere: a thin pane, or holes of an alpha mask.
    pub(crate) passes: bool,
    /// Whether the corners' normals point to the other side than the geometric one.
    pub(crate) inverted: bool,
}

impl Facet {
    /// Triangle `id` of a checked scene, and its area in square metres.
    pub(crate) fn new(scene: &Scene, id: usize) -> (Facet, f64) {
        let corners = scene.triangles[id].map(|v| scene.positions[v as usize]);
        let [p0, p1, p2] = corners;
        let doubled = doubled_area(corners);
        let normal = doubled.normalize_or_zero().as_vec3();
        let largest = p0.abs().max(p1.abs()).max(p2.abs()).max_element();
        let material = scene.triangle_material[id];
        let textures = &scene.materials[material as usize];
        let facet = Facet {
            corner: p0,
            edges: [p1 - p0, p2 - p0],
            normal,
            lift: LIFT * largest.max(f32::MIN_POSITIVE),
            material,
            smooth: is_smooth(scene, id, normal, textures),
            textured: textures.varies(),
            encloses: Bsdf::of(textures).interior().is_some(),
            passes: textures.opacity.lets_through()
                || Bsdf::of(textures).straight(1.0) != Vec3::ZERO,
            inverted: is_inverted(scene, id, normal),
        };
        (facet, 0.5 * doubled.length())
    }

    /// Whether a viewer in direction `v` is on the inner side.
    #[inline(always)]
    pub(crate) fn is_inside(&self, v: Vec3) -> bool {
        (self.normal.dot(v) < 0.0) != self.inverted
    }

    /// The point with these barycentrics.
    #[inline(always)]
    pub(crate) fn position(&self, [b1, b2]: [f32; 2]) -> Vec3 {
        self.corner + self.edges[0] * b1 + self.edges[1] * b2
    }
}

/// Whether anything bends the geometric normal of a triangle: a map, or corner normals that
/// are not, to rounding, its own.
fn is_smooth(scene: &Scene, id: usize, normal: Vec3, material: &Material) -> bool {
    let normals = scene.triangles[id].map(|v| scene.normals[v as usize]);
    let none = normals.iter().all(|n| *n == Vec3::ZERO);
    let own = normals.iter().all(|n| {
        let unit = n.normalize_or_zero();
        unit != Vec3::ZERO && unit.cross(normal).length() < 1e-6
    });
    material.normal_texture != INVALID || !(none || own)
}

/// Whether the corners' normals, where there are some, tell another outer side than the corners' order.
fn is_inverted(scene: &Scene, id: usize, normal: Vec3) -> bool {
    let normals = scene.triangles[id].map(|v| scene.normals[v as usize]);
    normals.iter().sum::<Vec3>().dot(normal) < 0.0
}

/// Cross product of two edges: along the geometric normal, as long as twice the area. In f64,
/// so that needles keep a direction.
fn doubled_area(corners: [Vec3; 3]) -> DVec3 {
    let [p0, p1, p2] = corners.map(Vec3::as_dvec3);
    (p1 - p0).cross(p2 - p0)
}
