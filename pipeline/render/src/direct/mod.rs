//! Light straight from the lights: points and parallel light exactly, all others by sampling.

pub(crate) mod emitter;
mod gain;
mod groups;
mod light_tree;
mod numbers;
mod plan;
mod planned;
mod points;
mod rows;
mod sampled;
mod visibility;

pub(crate) use groups::SampledLights;
pub use plan::ShadowRays;
pub(crate) use points::PointLighting;
pub(crate) use rows::Rows;
pub(crate) use sampled::SampledLighting;
