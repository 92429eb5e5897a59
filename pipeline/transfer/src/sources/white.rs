//! A light apart from its colour: what stands still is asked for once, whatever its colour does.

use glam::Vec3;
use rrf_lights::LightSource;
use std::hash::{DefaultHasher, Hasher};

/// The light in white, one unit a channel, and the colour that makes it the light again.
pub fn in_white(source: &LightSource) -> (LightSource, Vec3) {
    let mut white = source.clone();
    let colour = match &mut white {
        LightSource::Point(light) => &mut light.intensity,
        LightSource::Goniometric(light) => &mut light.intensity,
        LightSource::Spot(light) => &mut light.intensity,
        LightSource::Distant(light) => &mut light.irradiance,
        LightSource::Environment(light) => &mut light.radiance,
    };
    let colour = std::mem::replace(colour, Vec3::ONE);
    (white, colour)
}

/// A number that tells lights apart.
pub(crate) fn fingerprint(source: &LightSource) -> u64 {
    let mut hasher = DefaultHasher::new();
    source.words(&mut |word| hasher.write_u32(word));
    hasher.finish()
}
