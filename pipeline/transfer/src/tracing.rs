//! All that this crate asks of the tracer, in one place.

use crate::TransferError;
use glam::Vec3;

pub use rrf_materials::Bsdf;
pub use rrf_sampling::Stream;
pub use rrf_sampling::sobol::{DIMENSIONS, Scramble, Table, scramble};
pub use rrf_trace::{Hits, Rays, SurfacePoint, Tracer};

/// The first direction of a path and what scattering into it carries.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FirstStep {
    /// Unit direction, world frame.
    pub(crate) direction: Vec3,
    /// f cos / pdf for the surface's own colour.
    pub(crate) weight: Vec3,
    /// The same for a base colour of 0.
    pub(crate) constant: f32,
    /// What a base colour of 1 adds to it: both kinds of material are affine in the base colour.
    pub(crate) base: f32,
}

/// A direction in which `bsdf` scatters light toward `v`, and f cos / pdf; `None` where nothing
/// goes.
#[inline]
pub(crate) fn step(bsdf: &Bsdf, n: Vec3, v: Vec3, u: [f32; 3]) -> Option<(Vec3, Vec3)> {
    let sampled = bsdf.sample(n, v, u);
    (sampled.pdf > 0.0).then_some((sampled.l, sampled.weight))
}

/// [`step`] with the two parts of its weight.
pub(crate) fn first_step(bsdf: &Bsdf, n: Vec3, v: Vec3, u: [f32; 3]) -> Option<FirstStep> {
    let sampled = bsdf.sample(n, v, u);
    if sampled.pdf <= 0.0 {
        return None;
    }
    let coloured = |base_color| Bsdf {
        base_color,
        ..*bsdf
    };
    let black = coloured(Vec3::ZERO).eval(n, v, sampled.l).x;
    let white = coloured(Vec3::ONE).eval(n, v, sampled.l).x;
    Some(FirstStep {
        direction: sampled.l,
        weight: sampled.weight,
        constant: black / sampled.pdf,
        base: (white - black) / sampled.pdf,
    })
}

/// An error where the tracer was told to give up: what it found meanwhile is not whole.
pub(crate) fn unless_halted(tracer: &Tracer) -> Result<(), TransferError> {
    match tracer.is_halted() {
        true => Err(TransferError::Halted),
        false => Ok(()),
    }
}

/// Whether a material reflects alike in all directions.
pub(crate) fn is_lambert(bsdf: &Bsdf) -> bool {
    !bsdf.kind.depends_on_viewer
}
