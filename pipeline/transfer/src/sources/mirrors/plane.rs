//! One flat mirror.

use crate::lights::Receiver;
use crate::sources::triangle::SeenTriangle;
use crate::tracing::Tracer;
use glam::{Vec2, Vec3};
use rrf_scene::Scene;

/// Triangles of one plane and material.
#[derive(Clone, Debug, Default)]
pub(super) struct Mirror {
    pub(super) normal: Vec3,
    pub(super) offset: f32,
    pub(super) triangles: Vec<u32>,
    pub(super) area: f32,
    /// Axes in the plane, and the bounds along them.
    axes: [Vec3; 2],
    low: Vec2,
    high: Vec2,
    /// Corners of a box about it.
    corners: [Vec3; 8],
}

impl Mirror {
    /// With its first triangle; its bounds are still to be found.
    pub(super) fn new(normal: Vec3, offset: f32, triangle: u32, area: f32) -> Mirror {
        Mirror {
            normal,
            offset,
            triangles: vec![triangle],
            area,
            ..Mirror::default()
        }
    }

    /// Finds its bounds.
    pub(super) fn bound(&mut self, scene: &Scene) {
        let (x, y) = self.normal.any_orthonormal_pair();
        self.axes = [x, y];
        (self.low, self.high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for &v in self
            .triangles
            .iter()
            .flat_map(|&t| &scene.triangles[t as usize])
        {
            let at = scene.positions[v as usize];
            (low, high) = (low.min(at), high.max(at));
            let flat = self.flat(at);
            (self.low, self.high) = (self.low.min(flat), self.high.max(flat));
        }
        self.corners = box_corners([low, high]);
    }

    pub(super) fn height(&self, x: Vec3) -> f32 {
        self.normal.dot(x) - self.offset
    }

    fn flat(&self, x: Vec3) -> Vec2 {
        Vec2::new(self.axes[0].dot(x), self.axes[1].dot(x))
    }

    /// A direction as the mirror shows it.
    pub(super) fn fold(&self, v: Vec3) -> Vec3 {
        v - 2.0 * self.normal.dot(v) * self.normal
    }

    /// Whether part of it may lie over a receiver's horizon.
    pub(super) fn is_above(&self, at: &Receiver) -> bool {
        let above = |c: &Vec3| (*c - at.position).dot(at.geometric) > 0.0;
        self.corners.iter().any(above)
    }

    /// Whether it may show a point something of a box: the image of the box's corners spans more than
    /// the box's.
    pub(super) fn may_show(&self, bounds: [Vec3; 2], from: Vec3) -> bool {
        let own = self.height(from);
        let corners = box_corners(bounds);
        let behind = |c: &Vec3| self.height(*c) * own <= 0.0;
        if corners.iter().all(behind) {
            return false;
        }
        if corners.iter().any(behind) {
            return true;
        }
        let (start, mut low, mut high) = (self.flat(from), Vec2::INFINITY, Vec2::NEG_INFINITY);
        for corner in corners {
            let share = own / (own + self.height(corner));
            let place = start + (self.flat(corner) - start) * share;
            (low, high) = (low.min(place), high.max(place));
        }
        low.cmple(self.high).all() && high.cmpge(self.low).all()
    }

    /// A direction to the mirror by three numbers in [0, 1), the distance, and the solid angle over its share of
    /// the samples.
    pub(super) fn sample(
        &self,
        scene: &Scene,
        from: Vec3,
        u: [f32; 3],
    ) -> Option<(Vec3, f32, f32)> {
        let seen = self.triangles.iter().map(|&t| {
            let corners = scene.triangles[t as usize].map(|v| scene.positions[v as usize]);
            SeenTriangle::new(corners, from)
        });
        let seen: Vec<SeenTriangle> = seen.collect();
        let upto = seen.iter().scan(0.0, |sum, s| {
            *sum += s.solid_angle;
            Some(*sum)
        });
        let upto: Vec<f64> = upto.collect();
        let chosen = rrf_sampling::warp::by_weight(&upto, u[0]);
        let share = rrf_sampling::warp::by_weight_probability(&upto, chosen);
        let (direction, distance, angle) = seen.get(chosen)?.sample([u[1], u[2]])?;
        (share > 0.0).then_some((direction, distance, angle / share as f32))
    }

    /// What the mirror leaves of light at a place of its plane (Schlick 1994); `None` beside it.
    pub(super) fn reflectance(
        &self,
        tracer: &Tracer,
        place: Vec3,
        direction: Vec3,
    ) -> Option<Vec3> {
        let scene = tracer.scene();
        let (triangle, at) = self.triangles.iter().find_map(|&id| {
            let corners = scene.triangles[id as usize].map(|v| scene.positions[v as usize]);
            Some((id, barycentrics(corners, self.normal, place)?))
        })?;
        let colour = tracer
            .material_at(&tracer.point(triangle, at.to_array()))
            .base_color;
        let cosine = direction.dot(self.normal).abs().min(1.0);
        Some(colour + (Vec3::ONE - colour) * (1.0 - cosine).powi(5))
    }
}

fn box_corners([low, high]: [Vec3; 2]) -> [Vec3; 8] {
    let pick = |bit: usize, axis: usize| if bit >> axis & 1 == 1 { high } else { low }[axis];
    std::array::from_fn(|i| Vec3::new(pick(i, 0), pick(i, 1), pick(i, 2)))
}

/// Weights of a triangle's second and third corner at a place in its plane, inside only.
fn barycentrics([a, b, c]: [Vec3; 3], normal: Vec3, place: Vec3) -> Option<Vec2> {
    let (e, f, d) = (b - a, c - a, place - a);
    let doubled = e.cross(f).dot(normal);
    let at = Vec2::new(d.cross(f).dot(normal), e.cross(d).dot(normal)) / doubled;
    (at.min_element() >= -1e-5 && at.element_sum() <= 1.0 + 1e-5).then_some(at)
}
