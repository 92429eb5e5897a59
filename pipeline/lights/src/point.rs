//! Isotropic point lights.

use crate::error::{LightError, check_colour, check_finite};
use crate::kind::{Arrival, Leaving, LightKind, MitsubaLight, hash_vectors, mitsuba_rgb, triple};
use crate::warp::{UNIFORM_SPHERE_DENSITY, uniform_sphere};
use glam::Vec3;
use std::f32::consts::PI;

/// An isotropic point light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointLight {
    /// World position.
    pub position: Vec3,
    /// Radiant intensity a channel [W/sr].
    pub intensity: Vec3,
}

/// Arrival from a point that sends `intensity` [W/sr] toward `at`; `None` at the point itself.
pub(crate) fn from_point(position: Vec3, at: Vec3, intensity: Vec3) -> Option<Arrival> {
    let to = position - at;
    let squared = to.length_squared();
    (squared >= f32::MIN_POSITIVE).then(|| {
        let distance = squared.sqrt();
        Arrival {
            toward: to / distance,
            distance,
            irradiance: intensity / squared,
            density: None,
        }
    })
}

impl LightKind for PointLight {
    const NAME: &'static str = "point";

    fn check(&self) -> Result<(), LightError> {
        check_finite("position", self.position)?;
        check_colour("intensity", self.intensity)
    }

    fn sample(&self, at: Vec3, _u: [f32; 2]) -> Option<Arrival> {
        from_point(self.position, at, self.intensity)
    }

    fn position(&self) -> Option<Vec3> {
        Some(self.position)
    }

    /// Uniform over the sphere.
    fn leave(&self, u: [f32; 2]) -> Option<Leaving> {
        Some(Leaving {
            direction: uniform_sphere(u),
            intensity: self.intensity,
            density: UNIFORM_SPHERE_DENSITY,
        })
    }

    fn intensity_toward(&self, _direction: Vec3) -> Vec3 {
        self.intensity
    }

    fn leave_density(&self, _direction: Vec3) -> f32 {
        UNIFORM_SPHERE_DENSITY
    }

    fn power(&self, _scene_radius: f32) -> Vec3 {
        self.intensity * (4.0 * PI)
    }

    fn dimmed(&self, factor: Vec3) -> PointLight {
        PointLight {
            intensity: self.intensity * factor,
            ..*self
        }
    }

    fn moved(&self, to: Vec3) -> Option<PointLight> {
        Some(PointLight {
            position: to,
            ..*self
        })
    }

    fn words(&self, sink: &mut dyn FnMut(u32)) {
        hash_vectors(&[self.position, self.intensity], sink);
    }

    fn summary(&self) -> String {
        format!(
            "at {}  {} W/sr",
            triple(self.position),
            triple(self.intensity)
        )
    }

    fn mitsuba(&self, _picture: &str) -> MitsubaLight {
        MitsubaLight {
            xml: mitsuba_point(self.position, self.intensity),
            ..MitsubaLight::default()
        }
    }
}

/// Mitsuba's isotropic point.
pub(crate) fn mitsuba_point(position: Vec3, intensity: Vec3) -> String {
    let Vec3 { x, y, z } = position;
    format!(
        "<emitter type=\"point\">\n<point name=\"position\" x=\"{x}\" y=\"{y}\" z=\"{z}\"/>\n\
         {}</emitter>\n",
        mitsuba_rgb("intensity", intensity)
    )
}
