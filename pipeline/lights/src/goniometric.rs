//! Points of light whose intensity depends on the direction, by a picture or an IES profile.

use crate::environment::EnvironmentMap;
use crate::error::{LightError, check_colour, check_finite};
use crate::ies::IesProfile;
use crate::kind::{Arrival, Leaving, LightKind, MitsubaLight, hash_vectors, triple};
use crate::point::{from_point, mitsuba_point};
use crate::warp::{UNIFORM_SPHERE_DENSITY, uniform_sphere};
use glam::{Mat3, Vec3};
use std::f32::consts::PI;

/// What the intensity is multiplied with in each direction.
#[derive(Clone, Debug, PartialEq)]
pub enum Profile {
    /// A picture over the sphere, in the world's directions.
    Picture(EnvironmentMap),
    /// A lamp maker's table \[cd\]; the matrix turns world directions into its frame
    /// ([`crate::Photometry`]), and may mirror them.
    Ies(IesProfile, Mat3),
}

/// A point light with a profile.
#[derive(Clone, Debug, PartialEq)]
pub struct GoniometricLight {
    /// World position.
    pub position: Vec3,
    /// Radiant intensity a channel where the profile is 1 [W/sr]; for a profile in candela,
    /// watts a lumen.
    pub intensity: Vec3,
    /// The profile.
    pub profile: Profile,
}

impl GoniometricLight {
    /// Radiant intensity [W/sr] in a unit world direction away from the light.
    pub fn intensity_in(&self, direction: Vec3) -> Vec3 {
        match &self.profile {
            Profile::Picture(map) => self.intensity * map.radiance(direction),
            Profile::Ies(table, to_table) => self.intensity * table.candela(*to_table * direction),
        }
    }

    /// Mean of the profile over all directions.
    fn mean(&self) -> Vec3 {
        match &self.profile {
            Profile::Picture(map) => map.integral(|_| 1.0) / (4.0 * PI),
            Profile::Ies(table, _) => Vec3::splat(table.lumens() as f32 / (4.0 * PI)),
        }
    }
}

impl LightKind for GoniometricLight {
    const NAME: &'static str = "goniometric";

    fn check(&self) -> Result<(), LightError> {
        check_finite("position", self.position)?;
        check_colour("intensity", self.intensity)
    }

    fn sample(&self, at: Vec3, _u: [f32; 2]) -> Option<Arrival> {
        let away = (at - self.position).try_normalize()?;
        let intensity = self.intensity_in(away);
        if intensity == Vec3::ZERO {
            return None;
        }
        from_point(self.position, at, intensity)
    }

    fn position(&self) -> Option<Vec3> {
        Some(self.position)
    }

    /// By a picture's light; uniform over the sphere for a table.
    fn leave(&self, u: [f32; 2]) -> Option<Leaving> {
        let (direction, density) = match &self.profile {
            Profile::Picture(map) => map.sample(u)?,
            Profile::Ies(..) => (uniform_sphere(u), UNIFORM_SPHERE_DENSITY),
        };
        Some(Leaving {
            direction,
            intensity: self.intensity_in(direction),
            density,
        })
    }

    fn intensity_toward(&self, direction: Vec3) -> Vec3 {
        self.intensity_in(direction)
    }

    fn leave_density(&self, direction: Vec3) -> f32 {
        match &self.profile {
            Profile::Picture(map) => map.density(direction),
            Profile::Ies(..) => UNIFORM_SPHERE_DENSITY,
        }
    }

    fn power(&self, _scene_radius: f32) -> Vec3 {
        self.intensity * self.mean() * (4.0 * PI)
    }

    fn dimmed(&self, factor: Vec3) -> GoniometricLight {
        GoniometricLight {
            intensity: self.intensity * factor,
            ..self.clone()
        }
    }

    fn moved(&self, to: Vec3) -> Option<GoniometricLight> {
        Some(GoniometricLight {
            position: to,
            ..self.clone()
        })
    }

    fn words(&self, sink: &mut dyn FnMut(u32)) {
        hash_vectors(&[self.position, self.intensity], sink);
        match &self.profile {
            Profile::Picture(map) => map.words(sink),
            Profile::Ies(table, to_table) => {
                hash_vectors(&to_table.to_cols_array_2d().map(Vec3::from), sink);
                table.words(sink);
            }
        }
    }

    fn summary(&self) -> String {
        let profile = match &self.profile {
            Profile::Picture(map) => format!("picture of {} x {}", map.size()[0], map.size()[1]),
            Profile::Ies(table, _) => {
                format!(
                    "IES profile, {:.0} lm, peak {} cd",
                    table.lumens(),
                    table.peak()
                )
            }
        };
        format!(
            "at {}  mean {} W/sr, {profile}",
            triple(self.position),
            triple(self.intensity * self.mean())
        )
    }

    /// Mitsuba has no point light with a profile.
    fn mitsuba(&self, _picture: &str) -> MitsubaLight {
        MitsubaLight {
            xml: mitsuba_point(self.position, self.intensity * self.mean()),
            picture: None,
            note: Some("a light's profile by direction is its mean in Mitsuba".into()),
        }
    }
}
