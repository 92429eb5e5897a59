//! Paths of a view's pixels.

use crate::error::RenderError;
use crate::tile::VisiblePoints;
use crate::view::{Lights, View};
use glam::Vec3;
use rrf_sampling::{Stage, Stream};
use rrf_scene::PointLight;
use rrf_trace::{
    Estimates, Queries, Reflections, Sampling, SurfacePoint, TraceError, Tracer, indirect,
    lamp_light,
};

/// Number and seed of a view's paths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PathOptions {
    /// Paths a pixel and light: a multiple of 2 `aa`², for two independent halves.
    pub spp: u32,
    /// Camera rays a pixel are `aa` x `aa`; 0 means 1.
    pub aa: u32,
    /// Seed of the random numbers.
    pub seed: u64,
}

/// A view to path-trace: everything that its rows share.
pub(super) struct Paths<'a> {
    pub(super) tracer: &'a Tracer<'a>,
    pub(super) view: &'a View,
    pub(super) lights: &'a Lights,
    pub(super) aa: u32,
    sampling: Sampling,
    seed: u64,
    /// Stage of the random streams; point light k has stream k.
    stage: Stage,
}

impl<'a> Paths<'a> {
    /// # Errors
    /// Of a view or lights that cannot be rendered, and of paths that cannot be shared evenly.
    pub(super) fn new(
        tracer: &'a Tracer<'a>,
        view: &'a View,
        lights: &'a Lights,
        options: PathOptions,
        stage: Stage,
    ) -> Result<Paths<'a>, RenderError> {
        view.check()?;
        lights.check()?;
        let (samples, aa) = (options.spp, options.aa.max(1));
        if samples == 0 || !samples.is_multiple_of(2 * aa * aa) {
            return Err(RenderError::Samples { samples, aa });
        }
        Ok(Paths {
            tracer,
            view,
            lights,
            aa,
            sampling: Sampling {
                paths: samples / (aa * aa),
                replicates: 2,
            },
            seed: options.seed,
            stage,
        })
    }

    /// Surface points that the camera rays of a row of pixels meet.
    pub(super) fn visible(&self, y: u32) -> VisiblePoints {
        VisiblePoints::of_row(self.tracer, self.view, y, self.aa)
    }

    /// Share of a camera ray in its pixel.
    pub(super) fn weight(&self) -> f32 {
        1.0 / (self.aa * self.aa) as f32
    }

    /// Every ray of the frame has its own index in a light's stream: that of a row's first.
    fn first(&self, y: u32) -> u64 {
        u64::from(y) * u64::from(self.view.width) * u64::from(self.aa * self.aa)
    }

    /// Indirect light of point light `k`, of 1 W/sr, at points of row `y`.
    pub(super) fn of_point_light(
        &self,
        (k, light): (u32, &PointLight),
        points: &[SurfacePoint],
        viewers: &[Vec3],
        y: u32,
    ) -> Result<Estimates, TraceError> {
        let places = vec![light.position; points.len()];
        let queries = Queries {
            points,
            viewers,
            lights: &places,
        };
        let stream = Stream::new(self.seed, self.stage, k);
        let Sampling { paths, replicates } = self.sampling;
        indirect(
            self.tracer,
            queries,
            paths,
            replicates,
            stream,
            self.first(y),
        )
    }

    /// Light of all area lights, by stream `stream`, at points of row `y`.
    pub(super) fn of_area_lights(
        &self,
        reflections: Reflections,
        stream: u32,
        seen: &VisiblePoints,
        y: u32,
    ) -> Result<Estimates, TraceError> {
        let (points, viewers) = (&seen.points, &seen.viewers);
        let stream = Stream::new(self.seed, self.stage, stream);
        let (sampling, first) = (self.sampling, self.first(y));
        lamp_light(
            self.tracer,
            points,
            viewers,
            reflections,
            sampling,
            stream,
            first,
        )
    }
}
