//! Which light of which rows is wanted.

use super::path::PathLight;
use crate::light_set::{LightSet, shared};
use crate::openings::{Openings, Walks};
use crate::surface::SurfacePoint;
use crate::tracer::Tracer;
use crate::walk::Stack;
use glam::Vec3;
use rrf_lights::{Arrival, DistantLight, EmittingTriangles, LightKind};
use rrf_sampling::Stream;
use std::f32::consts::PI;

/// Which lights shine.
#[derive(Clone, Copy)]
pub(crate) enum Source<'a> {
    /// Each row's own point light of 1 W/sr.
    Point {
        /// Whether paths are also connected to what the light's own rays met.
        connect: bool,
    },
    /// Each row's own sun of 1 W/m².
    Sun,
    /// Lights together.
    Set {
        /// The lights.
        set: &'a LightSet,
        /// Whether paths are also connected to what a point's own rays met.
        connect: bool,
    },
}

/// Which part of the light is wanted of all rows.
#[derive(Clone, Copy)]
pub(crate) struct Part<'a> {
    pub(crate) tracer: &'a Tracer<'a>,
    pub(crate) source: Source<'a>,
    /// One reflection only, or else two or more.
    pub(crate) direct: bool,
    /// Whether a row's own surface scatters by its broad part alone.
    pub(crate) broad: bool,
    /// How a path's survival follows its throughput ([`super::KEEP`]).
    pub(crate) keep: f32,
    /// Where the sky is aimed at, if that is known.
    pub(crate) openings: Option<&'a Openings>,
    pub(crate) stream: Stream,
}

/// Walks of the pilot that looks for openings, per path of a query; and bounds on their number.
const WALKS: f64 = 0.25;
const FEWEST_WALKS: f64 = 64.0;
const MOST_WALKS: f64 = 1024.0;

impl Part<'_> {
    /// Where light from afar comes in that reaches a query: by a pilot from its point.
    pub(crate) fn openings(
        &self,
        rows: &[Row],
        each: usize,
        stack: &mut Stack,
    ) -> Option<Openings> {
        let row = rows.first().filter(|_| self.source.has_far())?;
        let walks = (WALKS * (each * rows.len()) as f64).clamp(FEWEST_WALKS, MOST_WALKS);
        let walks = Walks {
            from: &[(row.point, row.viewer)],
            count: walks as u32,
            stream: self.stream,
            index: row.index,
        };
        let afar = |u| {
            let arrival = self
                .source
                .arrival_from_afar(row, row.point.position, u, None);
            arrival.map(|arrival| arrival.toward)
        };
        Openings::learn(self.tracer, walks, &afar, &|_| 1.0, stack)
    }
}

/// Where paths start.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row {
    pub(crate) point: SurfacePoint,
    /// Unit direction to the viewer.
    pub(crate) viewer: Vec3,
    /// Position of the point light or unit direction to the sun, if one shines.
    pub(crate) light: Vec3,
    /// Index of the sample in its stream.
    pub(crate) index: u64,
    /// Which independent part of the sample this is.
    pub(crate) replicate: u32,
}

/// A row's own sun.
fn sun(row: &Row) -> DistantLight {
    DistantLight::sun(row.light, Vec3::ONE)
}

impl<'a> Source<'a> {
    /// Whether nothing shines.
    pub(crate) fn is_dark(&self) -> bool {
        matches!(self, Source::Set { set, .. } if set.is_dark())
    }

    /// Whether paths have a point of light each.
    pub(crate) fn has_points(&self) -> bool {
        match self {
            Source::Point { .. } => true,
            Source::Sun => false,
            Source::Set { set, .. } => !set.points.is_empty(),
        }
    }

    /// Whether paths are connected to what their point's own ray met.
    pub(crate) fn connects(&self) -> bool {
        match *self {
            Source::Point { connect } => connect,
            Source::Sun => false,
            Source::Set { connect, .. } => connect && self.has_points(),
        }
    }

    /// Whether light comes from afar.
    pub(crate) fn has_far(&self) -> bool {
        match self {
            Source::Point { .. } => false,
            Source::Sun => true,
            Source::Set { set, .. } => !set.far.is_empty(),
        }
    }

    /// Triangles that emit, if there are any.
    pub(crate) fn triangles(&self) -> Option<(&'a LightSet, &'a EmittingTriangles)> {
        match *self {
            Source::Set { set, .. } if !set.triangles.is_empty() => Some((set, &set.triangles)),
            _ => None,
        }
    }

    /// A path's point of light, by a number in [0, 1) where there is a choice.
    pub(crate) fn point(&self, row: &Row, u: impl FnOnce() -> f32) -> PathLight {
        let mut light = PathLight {
            position: row.light,
            source: 0,
            scale: 1.0,
        };
        if let Source::Set { set, .. } = self {
            let (index, probability) = set.points.choose(u());
            if let Some(position) = set.points.source(index).and_then(|s| s.position()) {
                light = PathLight {
                    position,
                    source: index,
                    scale: 1.0 / probability,
                };
            }
        }
        light
    }

    /// Radiant intensity [W/sr] of a path's point of light in a direction away from it, over
    /// the probability of its choice, and the inverse density of its own rays \[sr\].
    #[inline]
    pub(crate) fn intensity(&self, light: &PathLight, away: Vec3) -> (Vec3, f32) {
        let Source::Set { set, .. } = self else {
            return (Vec3::ONE, 4.0 * PI);
        };
        match (set.points.source(light.source), away.try_normalize()) {
            (Some(source), Some(away)) => (
                source.intensity_toward(away) * light.scale,
                1.0 / source.leave_density(away),
            ),
            _ => (Vec3::ZERO, f32::INFINITY),
        }
    }

    /// Light that arrives from afar at a row's path, by three numbers in [0, 1).
    pub(crate) fn arrival_from_afar(
        &self,
        row: &Row,
        at: Vec3,
        u: [f32; 3],
        openings: Option<&Openings>,
    ) -> Option<Arrival> {
        match self {
            Source::Point { .. } => None,
            Source::Sun => sun(row).sample(at, [u[1], u[2]]),
            Source::Set { set, .. } => set.far.sample(at, u, openings),
        }
    }

    /// Radiance that a row's path meets from afar, by the balance heuristic of its direction's
    /// density against [`Source::arrival_from_afar`].
    pub(crate) fn met(
        &self,
        row: &Row,
        at: Vec3,
        toward: Vec3,
        density: f32,
        openings: Option<&Openings>,
    ) -> Vec3 {
        match self {
            Source::Point { .. } => Vec3::ZERO,
            Source::Sun => shared((&sun(row).into(), 1.0), at, toward, density, None),
            Source::Set { set, .. } => set.far.met(at, toward, density, openings),
        }
    }
}
