//! Boxes that lights or eyes may be in.

use glam::Vec3;
use rrf_field::columns;
use rrf_field::tree::Domain;
use serde::{Deserialize, Serialize};

/// An axis-aligned box of positions, of lights or of eyes, world frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Region {
    /// Corner of the smallest coordinates.
    pub minimum: [f32; 3],
    /// Corner of the largest coordinates.
    pub maximum: [f32; 3],
}

/// As it is typed: `x0,y0,z0,x1,y1,z1`.
impl std::fmt::Display for Region {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let ([x0, y0, z0], [x1, y1, z1]) = (self.minimum, self.maximum);
        write!(f, "{x0},{y0},{z0},{x1},{y1},{z1}")
    }
}

impl Region {
    /// The position at `u` in [0, 1)^3.
    pub fn at(&self, u: [f32; 3]) -> Vec3 {
        let (low, high) = (Vec3::from(self.minimum), Vec3::from(self.maximum));
        low + (high - low) * Vec3::from(u)
    }

    /// Whether a position lies in the box, borders included.
    pub fn contains(&self, p: Vec3) -> bool {
        (0..3).all(|i| self.minimum[i] <= p[i] && p[i] <= self.maximum[i])
    }

    /// The part of the box inside a cell's domain, or none.
    pub fn within(&self, domain: &Domain) -> Option<Region> {
        let minimum = std::array::from_fn(|i| self.minimum[i].max(domain.minimum[columns::L + i]));
        let maximum = std::array::from_fn(|i| self.maximum[i].min(domain.maximum[columns::L + i]));
        (0..3)
            .all(|i| minimum[i] <= maximum[i])
            .then_some(Region { minimum, maximum })
    }
}
