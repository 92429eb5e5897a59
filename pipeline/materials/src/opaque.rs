//! Answers of kinds that light does not pass.

use crate::Bsdf;
use glam::Vec3;

/// The index of refraction does not matter.
pub(crate) fn index(_: &Bsdf) -> f32 {
    1.0
}

/// Light does not travel inside.
pub(crate) fn interior(_: &Bsdf) -> Option<Vec3> {
    None
}

/// Nothing goes straight through.
pub(crate) fn straight(_: &Bsdf, _: f32) -> Vec3 {
    Vec3::ZERO
}
