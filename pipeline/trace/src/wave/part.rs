//! Which light of which rows is wanted.

use crate::surface::SurfacePoint;
use crate::tracer::Tracer;
use glam::Vec3;
use rrf_sampling::Stream;

/// Which lights shine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Source {
    /// Each row's own point light of 1 W/sr.
    Point {
        /// Whether paths are also connected to what the light's own rays met.
        connect: bool,
    },
    /// The scene's emitting triangles.
    Lamps,
}

/// Which part of the light is wanted of all rows.
#[derive(Clone, Copy)]
pub(crate) struct Part<'a> {
    pub(crate) tracer: &'a Tracer<'a>,
    pub(crate) source: Source,
    /// One reflection only, or else two or more.
    pub(crate) direct: bool,
    /// How a path's survival follows its throughput ([`super::KEEP`]).
    pub(crate) keep: f32,
    pub(crate) stream: Stream,
}

/// Where paths start.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row {
    pub(crate) point: SurfacePoint,
    /// Unit direction to the viewer.
    pub(crate) viewer: Vec3,
    /// Position of the point light, if one shines.
    pub(crate) light: Vec3,
    /// Index of the sample in its stream.
    pub(crate) index: u64,
    /// Which independent part of the sample this is.
    pub(crate) replicate: u32,
}
