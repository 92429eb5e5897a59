//! Sixty-four numbers side by side.

use glam::Vec3;

/// Lanes of a tile. Kernels always run over all of them; lanes past the end hold stale
/// numbers whose results nobody reads.
pub const TILE: usize = 64;

/// One number a lane.
pub type Lane = [f32; TILE];

/// One vector a lane.
#[derive(Clone)]
pub struct Lane3 {
    x: Lane,
    y: Lane,
    z: Lane,
}

impl Lane3 {
    /// All zero.
    pub const ZERO: Lane3 = Lane3 {
        x: [0.0; TILE],
        y: [0.0; TILE],
        z: [0.0; TILE],
    };

    /// Lane `i`.
    #[inline(always)]
    pub fn get(&self, i: usize) -> Vec3 {
        Vec3::new(self.x[i], self.y[i], self.z[i])
    }

    /// Writes lane `i`.
    #[inline(always)]
    pub fn set(&mut self, i: usize, v: Vec3) {
        self.x[i] = v.x;
        self.y[i] = v.y;
        self.z[i] = v.z;
    }
}
