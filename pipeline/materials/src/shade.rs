//! Tiles of materials, asked once for each kind present.

use crate::kinds::KINDS;
use crate::{Lane, Lane3, MaterialLanes, Scattered};

impl MaterialLanes {
    /// Values and densities of all lanes for (n, v, l).
    pub fn eval(&self, directions: [&Lane3; 3], out: &mut Scattered) {
        for kind in KINDS.iter().filter(|kind| self.has(kind)) {
            (kind.eval_lanes)(self, directions, out);
        }
    }

    /// Directions of all lanes for (n, v) and three numbers in [0, 1).
    pub fn sample(&self, directions: [&Lane3; 2], u: [&Lane; 3], out: &mut Scattered) {
        for kind in KINDS.iter().filter(|kind| self.has(kind)) {
            (kind.sample_lanes)(self, directions, u, out);
        }
    }
}
