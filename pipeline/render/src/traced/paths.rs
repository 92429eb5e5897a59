//! Paths of a view's pixels.

use crate::error::RenderError;
use crate::tile::VisiblePoints;
use crate::view::{Lights, View};
use glam::Vec3;
use rrf_lights::LightSource;
use rrf_sampling::{Stage, Stream};
use rrf_scene::PointLight;
use rrf_trace::{
    Estimates, Estimator, Illumination, LightSet, Queries, Reflections, Sampling, SurfacePoint,
    TraceError, Tracer, indirect, own_light,
};

/// Most lights that are exact, and most points that have paths of their own; of more, paths
/// choose one each.
const MOST_ALONE: usize = 10;

/// Rows of pixels that look for the openings of skies.
const PILOT_ROWS: u32 = 48;

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
    /// Lights whose direct light is exact: points, and other sharp ones.
    pub(super) exact: (&'a [PointLight], Vec<&'a LightSource>),
    /// Points that have paths of their own.
    pub(super) alone: &'a [PointLight],
    /// All others, whose direct light goes by paths, and whose indirect light does.
    pub(super) direct: LightSet,
    pub(super) indirect: LightSet,
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
        let points = lights.points.as_slice();
        let sources = || lights.sources.iter().map(|light| &light.source);
        let (visible, sharp): (Vec<_>, Vec<_>) = sources().partition(|s| s.is_visible());
        let dark = vec![Vec3::ZERO; tracer.scene().area_lights.len()];
        let dimmed = (!lights.dims.is_empty()).then_some(lights.dims.as_slice());
        let dims = if lights.area {
            dimmed
        } else {
            Some(dark.as_slice())
        };
        let as_sources = points.iter().map(|&light| LightSource::from(light));
        let few = points.len() <= MOST_ALONE;
        let together = as_sources.clone().filter(|_| !few);
        let indirect = tracer.light_set(dims, sources().cloned().chain(together))?;
        let (exact, direct) = if points.len() + sharp.len() <= MOST_ALONE {
            let visible = visible.into_iter().cloned();
            ((points, sharp), tracer.light_set(dims, visible)?)
        } else {
            let all = sources().cloned().chain(as_sources);
            (([].as_slice(), Vec::new()), tracer.light_set(dims, all)?)
        };
        let mut paths = Paths {
            tracer,
            view,
            exact,
            alone: if few { points } else { &[] },
            direct,
            indirect,
            aa,
            sampling: Sampling {
                paths: samples / (aa * aa),
                replicates: 2,
            },
            seed: options.seed,
            stage,
        };
        paths.find_openings();
        Ok(paths)
    }

    /// Where skies are seen from what the view shows: from some rows of its pixels.
    fn find_openings(&mut self) {
        if !self.indirect.has_sky() {
            return;
        }
        let (mut points, mut viewers) = (Vec::new(), Vec::new());
        let rows = self.view.height.min(PILOT_ROWS);
        for k in 0..rows {
            let seen = self.visible((2 * k + 1) * self.view.height / (2 * rows));
            points.extend(seen.points);
            viewers.extend(seen.viewers);
        }
        let stream = Stream::new(self.seed, self.stage, u32::MAX - 2);
        for lights in [&mut self.direct, &mut self.indirect] {
            (self.tracer).find_openings(lights, &points, &viewers, stream);
        }
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

    /// Light by one reflection or by more of all lights that have no paths of their own, at points
    /// of row `y`.
    pub(super) fn of_other_lights(
        &self,
        reflections: Reflections,
        points: &[SurfacePoint],
        viewers: &[Vec3],
        y: u32,
    ) -> Result<Estimates, TraceError> {
        let (lights, number) = match reflections {
            Reflections::One => (&self.direct, u32::MAX),
            Reflections::More => (&self.indirect, u32::MAX - 1),
        };
        let illumination = Illumination {
            lights,
            reflections,
            estimator: Estimator::Connected,
        };
        let stream = Stream::new(self.seed, self.stage, number);
        let (sampling, first) = (self.sampling, self.first(y));
        own_light(
            self.tracer,
            illumination,
            points,
            viewers,
            sampling,
            stream,
            first,
        )
    }
}
