//! The pieces that patches are made of.

use glam::{DVec3, Vec3};

/// Edge of a patch at a place, as a share of the largest: 1 where nothing asks for more.
pub type SizeField<'a> = &'a (dyn Fn(Vec3) -> f32 + Sync);

/// A triangular piece of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Piece {
    pub(super) triangle: u32,
    /// Weights of the triangle's second and third corner at the piece's corners.
    pub(super) corners: [[f32; 2]; 3],
    /// Square metres.
    pub(super) area: f32,
}

/// A cell of a plane, or a small triangle.
#[derive(Clone, Debug, Default)]
pub(super) struct Element {
    pub(super) area: f64,
    pub(super) centre: DVec3,
    pub(super) normal: Vec3,
    /// Edge that a patch should have here, metres.
    pub(super) edge: f64,
    pub(super) pieces: Vec<Piece>,
}

impl Element {
    pub(super) fn add(&mut self, middle: DVec3, area: f64) {
        self.centre += middle * area;
        self.area += area;
    }

    pub(super) fn finish(&mut self) {
        if self.area > 0.0 {
            self.centre /= self.area;
        }
    }
}
