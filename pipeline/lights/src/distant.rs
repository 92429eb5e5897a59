//! The sun and other lights from one direction.

use crate::error::{LightError, check_colour, check_finite};
use crate::kind::{Arrival, LightKind, MitsubaLight, hash_vectors, mitsuba_rgb, triple};
use crate::warp::{about, spread_between, spread_of, uniform_cone, uniform_cone_density};
use glam::Vec3;
use std::f32::consts::PI;

/// Angular diameter of the sun seen from the earth \[degrees\].
pub const SUN_DIAMETER: f32 = 0.53;

/// A disk of constant radiance, infinitely far away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DistantLight {
    /// Unit direction to the disk's middle.
    pub toward: Vec3,
    /// Irradiance on a plane that faces the middle [W/m²].
    pub irradiance: Vec3,
    /// Angular diameter \[degrees\]; 0: parallel light.
    pub diameter: f32,
}

/// Unit direction to an azimuth [degrees from -z towards +x] and an elevation [degrees above
/// the horizon], +y up.
pub fn sky_direction(azimuth: f64, elevation: f64) -> Vec3 {
    let (sine, cosine) = azimuth.to_radians().sin_cos();
    let (height, along) = elevation.to_radians().sin_cos();
    glam::DVec3::new(along * sine, height, -along * cosine).as_vec3()
}

/// Azimuth and elevation \[degrees\] of a direction: the inverse of [`sky_direction`], azimuth
/// in [0, 360).
pub fn azimuth_elevation(toward: Vec3) -> [f64; 2] {
    let d = toward.as_dvec3().normalize_or_zero();
    let azimuth = d.x.atan2(-d.z).to_degrees().rem_euclid(360.0);
    [azimuth, d.y.clamp(-1.0, 1.0).asin().to_degrees()]
}

impl DistantLight {
    /// The sun: irradiance [W/m²] on a plane that faces it, the diameter seen from the earth.
    pub fn sun(toward: Vec3, irradiance: Vec3) -> DistantLight {
        DistantLight {
            toward,
            irradiance,
            diameter: SUN_DIAMETER,
        }
    }

    /// 1 - cos of half the diameter.
    fn spread(&self) -> f32 {
        spread_of(0.5 * f64::from(self.diameter).to_radians())
    }

    /// Radiance of the disk [W/(sr m²)]: a disk of half angle α that faces a plane has
    /// ∫ cos dω = π sin² α.
    fn disk_radiance(&self, spread: f32) -> Vec3 {
        self.irradiance / (PI * spread * (2.0 - spread))
    }
}

impl LightKind for DistantLight {
    const NAME: &'static str = "distant";

    fn check(&self) -> Result<(), LightError> {
        check_finite("direction", self.toward)?;
        check_colour("irradiance", self.irradiance)?;
        match self.diameter >= 0.0 && self.diameter < 180.0 {
            true => Ok(()),
            false => Err(LightError::Number {
                what: "angular diameter",
                value: self.diameter,
                wanted: "a number of degrees from 0 to below 180",
            }),
        }
    }

    /// Uniform over the disk by solid angle.
    fn sample(&self, _at: Vec3, u: [f32; 2]) -> Option<Arrival> {
        let spread = self.spread();
        if spread == 0.0 {
            return Some(Arrival {
                toward: self.toward,
                distance: f32::INFINITY,
                irradiance: self.irradiance,
                density: None,
            });
        }
        let density = uniform_cone_density(spread);
        Some(Arrival {
            toward: about(self.toward, uniform_cone(u, spread)),
            distance: f32::INFINITY,
            irradiance: self.disk_radiance(spread) / density,
            density: Some(density),
        })
    }

    fn radiance(&self, toward: Vec3) -> Vec3 {
        let spread = self.spread();
        if spread > 0.0 && spread_between(self.toward, toward) <= spread {
            self.disk_radiance(spread)
        } else {
            Vec3::ZERO
        }
    }

    fn is_visible(&self) -> bool {
        self.spread() > 0.0
    }

    fn density(&self, _at: Vec3, toward: Vec3) -> f32 {
        let spread = self.spread();
        if spread > 0.0 && spread_between(self.toward, toward) <= spread {
            uniform_cone_density(spread)
        } else {
            0.0
        }
    }

    fn power(&self, scene_radius: f32) -> Vec3 {
        self.irradiance * (PI * scene_radius * scene_radius)
    }

    fn dimmed(&self, factor: Vec3) -> DistantLight {
        DistantLight {
            irradiance: self.irradiance * factor,
            ..*self
        }
    }

    fn words(&self, sink: &mut dyn FnMut(u32)) {
        hash_vectors(&[self.toward, self.irradiance], sink);
        sink(self.diameter.to_bits());
    }

    fn summary(&self) -> String {
        let [azimuth, elevation] = azimuth_elevation(self.toward);
        format!(
            "azimuth {azimuth:.1}, elevation {elevation:.1} degrees  {} W/m² on a plane facing \
             it, {} degrees across",
            triple(self.irradiance),
            self.diameter
        )
    }

    fn mitsuba(&self, _picture: &str) -> MitsubaLight {
        let Vec3 { x, y, z } = -self.toward;
        MitsubaLight {
            xml: format!(
                "<emitter type=\"directional\">\n\
                 <vector name=\"direction\" x=\"{x}\" y=\"{y}\" z=\"{z}\"/>\n{}</emitter>\n",
                mitsuba_rgb("irradiance", self.irradiance)
            ),
            picture: None,
            note: (self.diameter > 0.0).then(|| {
                format!(
                    "a sun {} degrees across is parallel light in Mitsuba",
                    self.diameter
                )
            }),
        }
    }
}
