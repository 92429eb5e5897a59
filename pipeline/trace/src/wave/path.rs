//! The rows that a wave moves about.

use crate::media::Media;
use crate::mirrors::NO_MIRROR;
use crate::surface::Vertex;
use glam::Vec3;

/// One live path.
#[derive(Clone, Copy)]
pub(crate) struct Path {
    /// Row of the batch.
    pub(crate) row: u32,
    /// Number in the row's replicate.
    pub(crate) number: u32,
    /// Place among the batch's paths: row times paths a row plus path.
    pub(crate) slot: u32,
    pub(crate) triangle: u32,
    pub(crate) barycentrics: [f32; 2],
    /// Unit direction to where the path came from.
    pub(crate) viewer: Vec3,
    /// Product of f cos / pdf.
    pub(crate) throughput: Vec3,
    /// Largest channel of the throughput after the first scattering.
    pub(crate) first: f32,
    /// Density of the last direction (solid angle) until the ray is traced, then of the vertex
    /// (area).
    pub(crate) density: f32,
    /// Solids of glass that it is in.
    pub(crate) media: Media,
    /// Where the path came from.
    pub(crate) from: Vec3,
    /// Density with which a mirror would have led here, with respect to area.
    pub(crate) mirror_density: f32,
}

/// A path's point of light.
#[derive(Clone, Copy)]
pub(crate) struct PathLight {
    pub(crate) position: Vec3,
    /// Which of the set's points it is.
    pub(crate) source: u32,
    /// One over the probability of its choice.
    pub(crate) scale: f32,
}

/// The point that a light's own ray met.
#[derive(Clone, Copy)]
pub(crate) struct LightVertex {
    pub(crate) vertex: Vertex,
    /// Unit direction to the light.
    pub(crate) toward: Vec3,
    /// Irradiance at normal incidence from 1 W/sr; zero when nothing was met.
    pub(crate) falloff: f32,
    /// Intensity toward it, over the probability of the light's choice.
    pub(crate) intensity: Vec3,
    /// Density with respect to area.
    pub(crate) density: f32,
    /// Mirror that it lies on.
    pub(crate) mirror: u8,
}

impl LightVertex {
    /// The ray met nothing.
    pub(crate) const NONE: LightVertex = LightVertex {
        vertex: Vertex::NONE,
        toward: Vec3::Z,
        falloff: 0.0,
        intensity: Vec3::ZERO,
        density: 0.0,
        mirror: NO_MIRROR,
    };
}

/// A path's vertex and the mirror that it looks at.
#[derive(Clone, Copy)]
pub(crate) struct Connection {
    pub(crate) path: Path,
    pub(crate) mirror: u8,
    /// How often this mirror is taken from there.
    pub(crate) share: f32,
}
