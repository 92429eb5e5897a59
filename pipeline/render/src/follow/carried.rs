//! What a ray brings back to its pixel.

use glam::Vec3;

/// Share of the distance by which a ray may meet a surface before or behind the place that it is meant for.
const ON_TARGET: f32 = 1e-3;

/// How the surface that a ray meets is lit straight from the lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lit {
    /// As it is.
    Whole,
    /// With its narrow lobes widened: what it throws on the broad surface that sent the ray is a
    /// caustic, which rays meet too seldom (path space regularization: Kaplanyan and Dachsbacher
    /// 2013).
    Widened,
    /// By the light of its patch, taken as even, as the model takes it: it is farther away than the patch is
    /// wide.
    Even,
    /// Not at all: the model has what this flat mirror throws straight on others.
    Not,
}

/// What a ray carries from the camera on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Carried {
    /// Pixel, counted over the tile's band of the picture.
    pub(crate) pixel: u32,
    /// Share of the light that it meets which reaches the camera ray.
    pub(crate) throughput: Vec3,
    /// Share of the camera ray's trust that hangs on it.
    pub(crate) share: f32,
    /// Density of shadow rays to a lamp of level 1, over its own density; infinite where lamps are
    /// left to the shadow rays altogether.
    pub(crate) rival: f32,
    /// Radiance from afar that it brings if it leaves the scene.
    pub(crate) far: Vec3,
    /// Whether the surface that it meets is shaded; otherwise it brings the emission of a lamp at the
    /// most.
    pub(crate) surface: bool,
    /// How that surface is lit.
    pub(crate) lit: Lit,
    /// Rays to bright patches a square radian, over the ray's own density; once it met a surface, times
    /// the squared distance: what [`super::MetPatches::density`] is weighed with.
    pub(crate) guide: f32,
    /// Distance of the bright patch that it is meant for; 0 for other rays.
    pub(crate) target: f32,
    /// Distance that it travelled.
    pub(crate) length: f32,
}

impl Carried {
    /// A camera ray.
    pub(crate) fn camera(pixel: u32) -> Carried {
        Carried {
            pixel,
            throughput: Vec3::ONE,
            share: 1.0,
            rival: 0.0,
            far: Vec3::ZERO,
            surface: true,
            lit: Lit::Whole,
            guide: 0.0,
            target: 0.0,
            length: 0.0,
        }
    }

    /// Whether a surface at a distance is the one that it is meant for.
    pub(crate) fn is_meant_for(&self, distance: f32) -> bool {
        self.target == 0.0 || (distance / self.target - 1.0).abs() < ON_TARGET
    }

    /// Weight of the emission of a lamp of that level, by the balance heuristic.
    pub(crate) fn lamp_weight(&self, level: f32) -> f32 {
        1.0 / (1.0 + self.rival * level.max(f32::MIN_POSITIVE))
    }
}
