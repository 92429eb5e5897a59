//! Directions to a light from afar: of a sky, a share of them through openings.

use super::Openings;
use glam::Vec3;
use rrf_lights::{Arrival, LightSource};

/// A direction to a light for light that is to arrive at `at`, by three numbers in [0, 1).
pub(crate) fn aim(
    source: &LightSource,
    openings: Option<&Openings>,
    at: Vec3,
    u: [f32; 3],
) -> Option<Vec3> {
    let guided = openings.filter(|openings| source.is_sky() && u[0] < openings.share());
    match guided {
        Some(openings) => {
            let through = openings.sample([u[0] / openings.share(), u[1], u[2]])?;
            (through - at).try_normalize()
        }
        None => Some(source.sample(at, [u[1], u[2]])?.toward),
    }
}

/// Density of [`aim`] with respect to solid angle, for a light that a ray can meet.
pub(crate) fn aim_density(
    source: &LightSource,
    openings: Option<&Openings>,
    at: Vec3,
    toward: Vec3,
) -> f32 {
    let own = source.density(at, toward);
    match openings.filter(|_| source.is_sky()) {
        Some(openings) => {
            let share = openings.share();
            (1.0 - share) * own + share * openings.angle_density(at, toward)
        }
        None => own,
    }
}

impl Openings {
    /// Light that arrives at `at` from a sky, by three numbers in [0, 1): a share of the directions
    /// goes through openings, the others are the sky's own.
    pub fn arrival(&self, sky: &LightSource, at: Vec3, u: [f32; 3]) -> Option<Arrival> {
        let toward = aim(sky, Some(self), at, u)?;
        let density = aim_density(sky, Some(self), at, toward);
        Some(Arrival {
            toward,
            distance: f32::INFINITY,
            irradiance: sky.radiance(toward) / density,
            density: Some(density),
        })
    }

    /// Density of [`Openings::arrival`] with respect to solid angle [1/sr].
    pub fn density(&self, sky: &LightSource, at: Vec3, toward: Vec3) -> f32 {
        aim_density(sky, Some(self), at, toward)
    }
}
