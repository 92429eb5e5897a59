//! When a line meets a triangle.
//!
//! Edges are tested by the sign of Pluecker products that two neighbours compute from the
//! same numbers with opposite signs (Davidovic et al. 2012), so no ray slips between them.

use glam::{DVec3, Vec3};

/// A triangle as lines and rays are tested against it, relative to the scene's middle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edges {
    /// Unit geometric normal n and its product c with a corner: the plane n.x = c.
    pub(super) plane: [f32; 4],
    /// For the edges opposite to corners 0, 1, 2, from a to b: b - a, then a x b.
    pub(super) edges: [[f32; 6]; 3],
}

/// A ray with what all its tests share.
#[derive(Clone, Copy)]
pub(super) struct Line {
    pub(super) origin: Vec3,
    pub(super) direction: Vec3,
    /// origin x direction.
    pub(super) moment: Vec3,
}

/// Where a line meets a triangle's plane.
#[derive(Clone, Copy)]
pub(super) struct Meeting {
    /// Whether the place lies inside the triangle.
    pub(super) inside: bool,
    pub(super) t: f32,
    /// Weights of the corners, up to a common factor.
    pub(super) weights: [f32; 3],
}

impl Line {
    #[inline(always)]
    pub(super) fn new(origin: Vec3, direction: Vec3) -> Line {
        Line {
            origin,
            direction,
            moment: origin.cross(direction),
        }
    }
}

impl Edges {
    /// In f64, where products of corners are exact or nearly: in f32 the moment of a small
    /// triangle would drown in its distance from the origin.
    pub(super) fn new(corners: [Vec3; 3], centre: DVec3) -> Edges {
        let [p0, p1, p2] = corners.map(|p| p.as_dvec3() - centre);
        let normal = (p1 - p0).cross(p2 - p0).normalize_or_zero();
        let plane = [normal.x, normal.y, normal.z, normal.dot(p0)];
        let edges = [(p1, p2), (p2, p0), (p0, p1)].map(|(a, b)| {
            let (along, moment) = (b - a, a.cross(b));
            [along.x, along.y, along.z, moment.x, moment.y, moment.z]
        });
        Edges {
            plane: plane.map(|x| x as f32),
            edges: edges.map(|edge| edge.map(|x| x as f32)),
        }
    }

    #[inline(always)]
    pub(super) fn meet(&self, line: &Line) -> Meeting {
        let (o, d, m) = (line.origin, line.direction, line.moment);
        // A loop, not `map`: see `Wide::closest_of`.
        let mut weights = [0.0; 3];
        for (weight, e) in weights.iter_mut().zip(&self.edges) {
            *weight =
                (e[0] * m.x + e[1] * m.y + e[2] * m.z) + (e[3] * d.x + e[4] * d.y + e[5] * d.z);
        }
        let [nx, ny, nz, c] = self.plane;
        let slope = nx * d.x + ny * d.y + nz * d.z;
        let low = min(min(weights[0], weights[1]), weights[2]);
        let high = max(max(weights[0], weights[1]), weights[2]);
        Meeting {
            inside: (low >= 0.0) | (high <= 0.0),
            t: (c - (nx * o.x + ny * o.y + nz * o.z)) / slope,
            weights,
        }
    }
}

/// Weights of the second and third corner that sum to 1 with that of the first.
#[inline(always)]
pub(super) fn barycentrics([w0, w1, w2]: [f32; 3]) -> [f32; 2] {
    let sum = w0 + w1 + w2;
    let scale = if sum == 0.0 { 0.0 } else { 1.0 / sum };
    [w1 * scale, w2 * scale]
}

#[inline(always)]
pub(super) fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline(always)]
pub(super) fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}
