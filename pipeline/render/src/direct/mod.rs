//! Light straight from the lights: points and parallel light exactly, all others by sampling.

pub(crate) mod emitter;
mod groups;
mod light_tree;
mod points;
mod rows;
mod sampled;

pub(crate) use groups::SampledLights;
pub(crate) use points::PointLighting;
pub(crate) use rows::Rows;
pub(crate) use sampled::SampledLighting;
pub use sampled::ShadowRays;
