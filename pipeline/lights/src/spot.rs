//! Spot lights: a point whose intensity falls off about an axis as its format defines it.

use crate::error::{LightError, check_colour, check_finite};
use crate::kind::{Arrival, Leaving, LightKind, MitsubaLight, hash_vectors, mitsuba_rgb, triple};
use crate::point::from_point;
use crate::warp::{about, spread_between, uniform_cone, uniform_cone_density};
use glam::Vec3;
use std::f32::consts::TAU;

/// The falloff between the inner and the outer cone, of t = (cos a - cos outer) /
/// (cos inner - cos outer), kept in [0, 1].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Falloff {
    /// t² (3 - 2 t): pbrt version 4 (`SmoothStep` in `lights.cpp`).
    Smoothstep,
    /// t⁴: pbrt version 3 (`SpotLight::Falloff` in `spot.cpp`).
    Quartic,
    /// t², and the cosines at least 0.001 apart: KHR_lights_punctual's recommendation.
    Squared,
}

impl Falloff {
    /// Mean of the falloff over cosines between the two cones.
    fn mean(self) -> f32 {
        match self {
            Falloff::Smoothstep => 0.5,
            Falloff::Quartic => 0.2,
            Falloff::Squared => 1.0 / 3.0,
        }
    }
}

/// A spot light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpotLight {
    /// World position.
    pub position: Vec3,
    /// Unit direction of the axis, away from the light.
    pub axis: Vec3,
    /// Radiant intensity a channel on the axis [W/sr].
    pub intensity: Vec3,
    /// Half angle within which the intensity is full \[radians\].
    pub inner: f32,
    /// Half angle beyond which there is no light \[radians\], at most π.
    pub outer: f32,
    /// The course between them.
    pub falloff: Falloff,
}

impl SpotLight {
    /// 1 - cos of the angles where the light begins to fall and where it has ended.
    fn spreads(&self) -> [f32; 2] {
        let [inner, outer] = [self.inner, self.outer].map(|a| crate::warp::spread_of(f64::from(a)));
        match self.falloff {
            Falloff::Squared => [inner.min(outer - 0.001), outer],
            Falloff::Smoothstep | Falloff::Quartic => [inner.min(outer), outer],
        }
    }

    /// Share of the axis' intensity that goes in a unit direction away from the light.
    pub fn share(&self, direction: Vec3) -> f32 {
        let [inner, outer] = self.spreads();
        let spread = spread_between(self.axis, direction);
        if spread >= outer {
            return 0.0;
        }
        if spread <= inner {
            return 1.0;
        }
        let t = (outer - spread) / (outer - inner);
        match self.falloff {
            Falloff::Smoothstep => t * t * (3.0 - 2.0 * t),
            Falloff::Quartic => (t * t) * (t * t),
            Falloff::Squared => t * t,
        }
    }

    /// The solid angle that, filled with the axis' intensity, has the light's power \[sr\]:
    /// 2π times the integral of the falloff over the cosine. (A glTF light whose cones are less
    /// than 0.001 apart near the axis never reaches its full intensity; this leaves it out.)
    pub fn solid_angle(&self) -> f32 {
        let [inner, outer] = self.spreads();
        TAU * (inner + (outer - inner) * self.falloff.mean())
    }
}

impl LightKind for SpotLight {
    const NAME: &'static str = "spot";

    fn check(&self) -> Result<(), LightError> {
        check_finite("position", self.position)?;
        check_finite("axis", self.axis)?;
        check_colour("intensity", self.intensity)?;
        let angle = |what, value: f32, good: bool| match good {
            true => Ok(()),
            false => Err(LightError::Number {
                what,
                value,
                wanted: "an angle from 0 to pi, the inner one not above the outer one,",
            }),
        };
        let largest = std::f32::consts::PI + 1e-6;
        angle(
            "outer angle",
            self.outer,
            self.outer > 0.0 && self.outer <= largest,
        )?;
        angle(
            "inner angle",
            self.inner,
            self.inner >= 0.0 && self.inner <= self.outer,
        )
    }

    fn sample(&self, at: Vec3, _u: [f32; 2]) -> Option<Arrival> {
        let away = (at - self.position).try_normalize()?;
        let share = self.share(away);
        if share == 0.0 {
            return None;
        }
        from_point(self.position, at, self.intensity * share)
    }

    fn position(&self) -> Option<Vec3> {
        Some(self.position)
    }

    /// Uniform over the outer cone.
    fn leave(&self, u: [f32; 2]) -> Option<Leaving> {
        let [_, outer] = self.spreads();
        let direction = about(self.axis, uniform_cone(u, outer));
        Some(Leaving {
            direction,
            intensity: self.intensity * self.share(direction),
            density: uniform_cone_density(outer),
        })
    }

    fn intensity_toward(&self, direction: Vec3) -> Vec3 {
        self.intensity * self.share(direction)
    }

    fn leave_density(&self, direction: Vec3) -> f32 {
        let [_, outer] = self.spreads();
        match spread_between(self.axis, direction) <= outer {
            true => uniform_cone_density(outer),
            false => 0.0,
        }
    }

    fn power(&self, _scene_radius: f32) -> Vec3 {
        self.intensity * self.solid_angle()
    }

    fn dimmed(&self, factor: Vec3) -> SpotLight {
        SpotLight {
            intensity: self.intensity * factor,
            ..*self
        }
    }

    fn moved(&self, to: Vec3) -> Option<SpotLight> {
        Some(SpotLight {
            position: to,
            ..*self
        })
    }

    fn words(&self, sink: &mut dyn FnMut(u32)) {
        hash_vectors(&[self.position, self.axis, self.intensity], sink);
        sink(self.inner.to_bits());
        sink(self.outer.to_bits());
        sink(self.falloff as u32);
    }

    fn summary(&self) -> String {
        format!(
            "at {} along {}  {} W/sr on the axis, {:.1} to {:.1} degrees",
            triple(self.position),
            triple(self.axis),
            triple(self.intensity),
            self.inner.to_degrees(),
            self.outer.to_degrees()
        )
    }

    /// Mitsuba's spot falls off linearly with the angle.
    fn mitsuba(&self, _picture: &str) -> MitsubaLight {
        let target = self.position + self.axis;
        let up = self.axis.any_orthonormal_vector();
        let list = |v: Vec3| format!("{}, {}, {}", v.x, v.y, v.z);
        let xml = format!(
            "<emitter type=\"spot\">\n<transform name=\"to_world\">\n\
             <lookat origin=\"{}\" target=\"{}\" up=\"{}\"/>\n</transform>\n{}\
             <float name=\"cutoff_angle\" value=\"{}\"/>\n\
             <float name=\"beam_width\" value=\"{}\"/>\n</emitter>\n",
            list(self.position),
            list(target),
            list(up),
            mitsuba_rgb("intensity", self.intensity),
            self.outer.to_degrees(),
            self.inner.to_degrees()
        );
        MitsubaLight {
            xml,
            picture: None,
            note: (self.inner < self.outer).then(|| {
                "a spot falls off linearly with the angle in Mitsuba, between the same angles"
                    .to_string()
            }),
        }
    }
}
