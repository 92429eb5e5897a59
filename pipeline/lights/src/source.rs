//! The kinds of light beside the surface's emission, in one list.

use crate::distant::DistantLight;
use crate::environment::Environment;
use crate::error::LightError;
use crate::goniometric::GoniometricLight;
use crate::kind::{Arrival, Leaving, LightKind, MitsubaLight};
use crate::point::PointLight;
use crate::spot::SpotLight;
use glam::Vec3;

/// Makes the enum of all kinds and hands every part of [`LightKind`] on to the kind.
macro_rules! kinds {
    ($($(#[$doc:meta])* $kind:ident($light:ty)),* $(,)?) => {
        /// A light beside the surface's own emission, of one of the kinds.
        #[derive(Clone, Debug, PartialEq)]
        pub enum LightSource {
            $($(#[$doc])* $kind($light),)*
        }

        $(impl From<$light> for LightSource {
            fn from(light: $light) -> LightSource {
                LightSource::$kind(light)
            }
        })*

        impl LightSource {
            /// [`LightKind::NAME`].
            pub fn kind(&self) -> &'static str {
                match self { $(LightSource::$kind(_) => <$light>::NAME,)* }
            }

            /// [`LightKind::check`].
            pub fn check(&self) -> Result<(), LightError> {
                match self { $(LightSource::$kind(light) => light.check(),)* }
            }

            /// [`LightKind::sample`].
            pub fn sample(&self, at: Vec3, u: [f32; 2]) -> Option<Arrival> {
                match self { $(LightSource::$kind(light) => light.sample(at, u),)* }
            }

            /// [`LightKind::radiance`].
            pub fn radiance(&self, toward: Vec3) -> Vec3 {
                match self { $(LightSource::$kind(light) => light.radiance(toward),)* }
            }

            /// [`LightKind::is_visible`].
            pub fn is_visible(&self) -> bool {
                match self { $(LightSource::$kind(light) => light.is_visible(),)* }
            }

            /// [`LightKind::density`].
            pub fn density(&self, at: Vec3, toward: Vec3) -> f32 {
                match self { $(LightSource::$kind(light) => light.density(at, toward),)* }
            }

            /// [`LightKind::position`].
            pub fn position(&self) -> Option<Vec3> {
                match self { $(LightSource::$kind(light) => light.position(),)* }
            }

            /// [`LightKind::leave`].
            pub fn leave(&self, u: [f32; 2]) -> Option<Leaving> {
                match self { $(LightSource::$kind(light) => light.leave(u),)* }
            }

            /// [`LightKind::intensity_toward`].
            pub fn intensity_toward(&self, direction: Vec3) -> Vec3 {
                match self { $(LightSource::$kind(light) => light.intensity_toward(direction),)* }
            }

            /// [`LightKind::leave_density`].
            pub fn leave_density(&self, direction: Vec3) -> f32 {
                match self { $(LightSource::$kind(light) => light.leave_density(direction),)* }
            }

            /// [`LightKind::power`].
            pub fn power(&self, scene_radius: f32) -> Vec3 {
                match self { $(LightSource::$kind(light) => light.power(scene_radius),)* }
            }

            /// [`LightKind::dimmed`].
            pub fn dimmed(&self, factor: Vec3) -> LightSource {
                match self { $(LightSource::$kind(light) => light.dimmed(factor).into(),)* }
            }

            /// [`LightKind::moved`].
            pub fn moved(&self, to: Vec3) -> Option<LightSource> {
                match self { $(LightSource::$kind(light) => light.moved(to).map(Into::into),)* }
            }

            /// Feeds the kind's name and [`LightKind::words`] to a hash.
            pub fn words(&self, sink: &mut dyn FnMut(u32)) {
                self.kind().bytes().for_each(|byte| sink(u32::from(byte)));
                match self { $(LightSource::$kind(light) => light.words(sink),)* }
            }

            /// [`LightKind::summary`].
            pub fn summary(&self) -> String {
                match self { $(LightSource::$kind(light) => light.summary(),)* }
            }

            /// [`LightKind::mitsuba`].
            pub fn mitsuba(&self, picture: &str) -> MitsubaLight {
                match self { $(LightSource::$kind(light) => light.mitsuba(picture),)* }
            }
        }
    };
}

impl LightSource {
    /// Whether light comes from all around.
    pub fn is_sky(&self) -> bool {
        matches!(self, LightSource::Environment(_))
    }
}

kinds! {
    /// An isotropic point.
    Point(PointLight),
    /// A point with a profile.
    Goniometric(GoniometricLight),
    /// A point with a cone.
    Spot(SpotLight),
    /// The sun, or parallel light.
    Distant(DistantLight),
    /// Radiance from all directions.
    Environment(Environment),
}

/// A light of the scene with its name.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnLight {
    /// Name, unique in the scene.
    pub name: String,
    /// The light.
    pub source: LightSource,
}
