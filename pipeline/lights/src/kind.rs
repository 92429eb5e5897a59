//! The parts that every kind of light has.

use crate::error::LightError;
use glam::Vec3;

/// Light that arrives at a point from one light, by one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrival {
    /// Unit direction to the light, world frame.
    pub toward: Vec3,
    /// Distance to it [scene units]; infinite for the sun and the sky.
    pub distance: f32,
    /// Unoccluded irradiance on a surface that faces `toward` [W/m²]: for a density, radiance
    /// over it, whose mean over samples of cosine times this is the light's irradiance.
    pub irradiance: Vec3,
    /// Density of `toward` with respect to solid angle [1/sr]; `None` where the light comes from
    /// this direction alone, which no other sampler can find.
    pub density: Option<f32>,
}

/// A direction that light leaves a point of light in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leaving {
    /// Unit direction away from the light, world frame.
    pub direction: Vec3,
    /// Radiant intensity [W/sr] into it.
    pub intensity: Vec3,
    /// Density with respect to solid angle [1/sr].
    pub density: f32,
}

/// An environment as a picture that looks every way: lat-long, +y up, row 0 at the zenith,
/// column 0 at -z, a quarter of the width at +x.
#[derive(Clone, Debug, PartialEq)]
pub struct Panorama {
    /// Texels across.
    pub width: u32,
    /// Texels down.
    pub height: u32,
    /// `width * height` texels of radiance [W/(sr m²)], row-major from the top.
    pub texels: Vec<Vec3>,
}

/// A light as Mitsuba 3 writes it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MitsubaLight {
    /// The `emitter` element.
    pub xml: String,
    /// The picture that the element names, to be written as EXR under that name.
    pub picture: Option<Panorama>,
    /// How Mitsuba's light differs, if it does.
    pub note: Option<String>,
}

/// A kind of light beside the surface's own emission: a file of this crate and a line in
/// [`crate::LightSource`] make one. Positions and directions are in the world frame.
pub trait LightKind: Clone + PartialEq {
    /// Name of the kind in listings.
    const NAME: &'static str;

    /// Refuses parameters that cannot be computed with.
    fn check(&self) -> Result<(), LightError>;

    /// Light that arrives at `at`, by two numbers in [0, 1); `None` where none does.
    fn sample(&self, at: Vec3, u: [f32; 2]) -> Option<Arrival>;

    /// Radiance [W/(sr m²)] that a ray meets that leaves the scene in direction `toward`.
    fn radiance(&self, _toward: Vec3) -> Vec3 {
        Vec3::ZERO
    }

    /// Whether a ray can meet the light: whether [`LightKind::radiance`] is not zero everywhere.
    fn is_visible(&self) -> bool {
        false
    }

    /// Density of [`LightKind::sample`] at `at` with respect to solid angle [1/sr]; 0 for a light
    /// of single directions.
    fn density(&self, _at: Vec3, _toward: Vec3) -> f32 {
        0.0
    }

    /// Position, where the light is a point.
    fn position(&self) -> Option<Vec3> {
        None
    }

    /// Direction of a light subpath, by two numbers in [0, 1), where the light is a point.
    fn leave(&self, _u: [f32; 2]) -> Option<Leaving> {
        None
    }

    /// Radiant intensity [W/sr] in a unit direction away from the light, where it is a point.
    fn intensity_toward(&self, _direction: Vec3) -> Vec3 {
        Vec3::ZERO
    }

    /// Density of [`LightKind::leave`] with respect to solid angle [1/sr].
    fn leave_density(&self, _direction: Vec3) -> f32 {
        0.0
    }

    /// Radiant power \[W\]: all that a point emits, or that a light from afar sends through a
    /// sphere of this radius.
    fn power(&self, scene_radius: f32) -> Vec3;

    /// The same light, every channel times a factor.
    fn dimmed(&self, factor: Vec3) -> Self;

    /// A copy of the light at another position, where it has one.
    fn moved(&self, _to: Vec3) -> Option<Self> {
        None
    }

    /// Feeds every number that changes the light to a hash.
    fn words(&self, sink: &mut dyn FnMut(u32));

    /// One line for people, with units.
    fn summary(&self) -> String;

    /// The light in Mitsuba's terms; `picture` is the file that a map is to be written to.
    fn mitsuba(&self, picture: &str) -> MitsubaLight;
}

/// Feeds the bits of vectors to a hash.
pub(crate) fn hash_vectors(values: &[Vec3], sink: &mut dyn FnMut(u32)) {
    for value in values {
        value.to_array().into_iter().for_each(|x| sink(x.to_bits()));
    }
}

/// Three numbers with spaces.
pub(crate) fn triple(v: Vec3) -> String {
    format!("{} {} {}", v.x, v.y, v.z)
}

/// A colour of a Mitsuba scene.
pub(crate) fn mitsuba_rgb(name: &str, v: Vec3) -> String {
    format!(
        "<rgb name=\"{name}\" value=\"{}, {}, {}\"/>\n",
        v.x, v.y, v.z
    )
}
