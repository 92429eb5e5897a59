//! Light straight from the lights: point lights exactly, all others by sampling.

pub(crate) mod emitter;
mod light_choice;
mod points;
mod sampled;

pub(crate) use points::PointLighting;
pub(crate) use sampled::SampledLighting;
pub use sampled::ShadowRays;
