//! What a ray brings back to its pixel.

use glam::Vec3;

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
        }
    }

    /// Weight of the emission of a lamp of that level, by the balance heuristic.
    pub(crate) fn lamp_weight(&self, level: f32) -> f32 {
        1.0 / (1.0 + self.rival * level.max(f32::MIN_POSITIVE))
    }
}
