//! Coplanar triangles of one object and material, and the plane's own coordinates.

use super::clip::Rect;
use glam::{DVec3, Vec3};
use rrf_scene::Scene;
use std::collections::BTreeMap;

/// Normals that differ by less than this count as one.
const TURN: f64 = 1e-3;
/// Planes that are apart by less than this share of the scene's size count as one.
const APART: f64 = 1e-5;

/// Triangles that lie in one plane and belong together.
#[derive(Clone, Debug)]
pub(super) struct Group {
    pub(super) triangles: Vec<u32>,
    pub(super) frame: PlaneFrame,
    /// What the triangles span in the plane's coordinates, metres.
    pub(super) span: Rect,
    /// Longest edge of any of them, metres.
    pub(super) longest: f64,
}

/// Coordinates in a plane.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlaneFrame {
    pub(super) origin: Vec3,
    pub(super) axes: [Vec3; 2],
    pub(super) normal: Vec3,
}

impl PlaneFrame {
    /// Coordinates of a place, metres.
    #[inline]
    pub(super) fn flat(&self, place: Vec3) -> [f64; 2] {
        let from = (place - self.origin).as_dvec3();
        self.axes.map(|axis| from.dot(axis.as_dvec3()))
    }

    /// The place with these coordinates.
    pub(super) fn place(&self, [x, y]: [f64; 2]) -> Vec3 {
        self.origin + self.axes[0] * x as f32 + self.axes[1] * y as f32
    }
}

/// Corners of a triangle.
pub(super) fn corners(scene: &Scene, triangle: u32) -> [Vec3; 3] {
    scene.triangles[triangle as usize].map(|v| scene.positions[v as usize])
}

/// Twice the area along the geometric normal.
pub(super) fn doubled_area(corners: [Vec3; 3]) -> DVec3 {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    (b - a).cross(c - a)
}

/// What patches must share: object, material, emission.
pub(super) fn kind(scene: &Scene, triangle: u32) -> [i64; 3] {
    let id = triangle as usize;
    let object = scene.triangle_object.get(id).copied().unwrap_or(0);
    [
        i64::from(object),
        i64::from(scene.triangle_material[id]),
        i64::from(scene.triangle_light[id]),
    ]
}

/// All triangles with an area, by plane; ordered by object, material and plane.
pub(super) fn groups(scene: &Scene) -> Vec<Group> {
    let largest = scene.positions.iter().map(|p| p.abs().max_element());
    let size = f64::from(largest.fold(f32::MIN_POSITIVE, f32::max));
    let mut found: BTreeMap<[i64; 7], Vec<u32>> = BTreeMap::new();
    for triangle in 0..scene.triangles.len() as u32 {
        let corners = corners(scene, triangle);
        let doubled = doubled_area(corners);
        if doubled.length() <= 0.0 {
            continue;
        }
        let normal = doubled.normalize();
        let offset = normal.dot(corners[0].as_dvec3()) / size;
        let [object, material, light] = kind(scene, triangle);
        let [x, y, z] = [normal.x, normal.y, normal.z].map(|c| (c / TURN).round() as i64);
        let key = [
            object,
            material,
            light,
            x,
            y,
            z,
            (offset / APART).round() as i64,
        ];
        found.entry(key).or_default().push(triangle);
    }
    (found.into_values())
        .filter_map(|triangles| group(scene, triangles))
        .collect()
}

/// The plane's x axis runs along the longest edge, so that rectangles are cut into rectangles.
fn group(scene: &Scene, triangles: Vec<u32>) -> Option<Group> {
    let mut longest = (0.0f32, Vec3::X);
    let mut summed = DVec3::ZERO;
    for &triangle in &triangles {
        let [a, b, c] = corners(scene, triangle);
        summed += doubled_area([a, b, c]);
        for edge in [b - a, c - b, a - c] {
            if edge.length() > longest.0 {
                longest = (edge.length(), edge);
            }
        }
    }
    let normal = summed.try_normalize()?.as_vec3();
    let x = longest.1.reject_from_normalized(normal).try_normalize()?;
    let frame = PlaneFrame {
        origin: corners(scene, *triangles.first()?)[0],
        axes: [x, normal.cross(x)],
        normal,
    };
    let mut span = Rect {
        low: [f64::INFINITY; 2],
        high: [f64::NEG_INFINITY; 2],
    };
    for &triangle in &triangles {
        for corner in corners(scene, triangle) {
            let at = frame.flat(corner);
            for (axis, x) in at.into_iter().enumerate() {
                span.low[axis] = span.low[axis].min(x);
                span.high[axis] = span.high[axis].max(x);
            }
        }
    }
    Some(Group {
        triangles,
        frame,
        span,
        longest: f64::from(longest.0),
    })
}
