//! Light of a scene's own lights, and of suns.

use crate::TraceError;
use crate::estimates::{Estimates, Sampling};
use crate::indirect::{Estimator, Queries};
use crate::light_set::LightSet;
use crate::openings::{Openings, Walks};
use crate::surface::SurfacePoint;
use crate::tracer::Tracer;
use crate::wave::{KEEP, Part, Row, Source};
use glam::Vec3;
use rrf_lights::{AreaLight, LightSource};
use rrf_sampling::Stream;

/// How often light was reflected before it reached the viewer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reflections {
    /// Once: direct light. What a point itself emits is not in it ([`Tracer::emission`]).
    One,
    /// Twice or more: indirect light.
    More,
}

/// Which light is wanted.
#[derive(Clone, Copy, Debug)]
pub struct Illumination<'a> {
    /// The lights that shine, of [`Tracer::light_set`].
    pub lights: &'a LightSet,
    /// Which part of their light.
    pub reflections: Reflections,
    /// How paths to points of light are made; but for [`Estimator::Bidirectional`], all others are
    /// found by next-event estimation and by the path's own directions, weighted by the balance
    /// heuristic.
    pub estimator: Estimator,
}

/// Walks that look for the openings of a view.
const VIEW_WALKS: u32 = 4096;
/// As many for a frame that a model answers, which is made many times a second.
const FRAME_WALKS: u32 = 1024;

/// Direction to a light from afar by three numbers in [0, 1), and how much a direction matters.
type Direction<'a> = dyn Fn([f32; 3]) -> Option<Vec3> + 'a;
type Weight<'a> = dyn Fn(Vec3) -> f32 + 'a;

impl Tracer<'_> {
    /// Lights that shine together: the scene's area lights times `dims`, one colour for each of
    /// them (none: as in the scene), and `sources`.
    ///
    /// # Errors
    /// If there are neither no dims nor as many as area lights.
    pub fn light_set(
        &self,
        dims: Option<&[Vec3]>,
        sources: impl IntoIterator<Item = LightSource>,
    ) -> Result<LightSet, TraceError> {
        let mut areas: Vec<AreaLight> = self.scene.area_lights.clone();
        if let Some(dims) = dims {
            if dims.len() != areas.len() {
                return Err(TraceError::Queries {
                    column: "dims",
                    found: dims.len(),
                    reference: "area lights",
                    expected: areas.len(),
                });
            }
            for (light, dim) in areas.iter_mut().zip(dims) {
                light.radiance *= *dim;
            }
        }
        Ok(LightSet::new(self.scene, &self.area_cdf, areas, sources))
    }

    /// Finds out where the skies of `lights` are seen from some points, by unit directions to their viewers, and
    /// from what these see: paths then aim there. Draws at index 0 of `stream`.
    pub fn find_openings(
        &self,
        lights: &mut LightSet,
        points: &[SurfacePoint],
        viewers: &[Vec3],
        stream: Stream,
    ) {
        if !lights.has_sky() {
            return;
        }
        let centre = 0.5 * (self.bounds[0] + self.bounds[1]);
        let afar = |u| Some(lights.far.sample(centre, u, None)?.toward);
        let weight = |toward| lights.radiance_from_afar(toward).element_sum();
        let seen = (points, viewers);
        lights.openings = self.learn_openings(seen, VIEW_WALKS, (&afar, &weight), stream);
    }

    /// Where skies are seen from some points, by unit directions to their viewers, and from what
    /// these see, for shadow rays to aim at; none if no sky is among `sources`, or nothing of it is
    /// seen. Draws at index 0 of `stream`.
    pub fn openings_of(
        &self,
        sources: &[&LightSource],
        (points, viewers): (&[SurfacePoint], &[Vec3]),
        stream: Stream,
    ) -> Option<Openings> {
        let skies = sources.iter().filter(|source| source.is_sky());
        let skies: Vec<&LightSource> = skies.copied().collect();
        let last = skies.len().checked_sub(1)?;
        let centre = 0.5 * (self.bounds[0] + self.bounds[1]);
        let afar = |[u, x, y]: [f32; 3]| {
            let chosen = (u * skies.len() as f32) as usize;
            Some(skies[chosen.min(last)].sample(centre, [x, y])?.toward)
        };
        let weight = |toward| {
            let skies = skies.iter().map(|sky| sky.radiance(toward));
            skies.sum::<Vec3>().element_sum()
        };
        let seen = (points, viewers);
        self.learn_openings(seen, FRAME_WALKS, (&afar, &weight), stream)
    }

    fn learn_openings(
        &self,
        (points, viewers): (&[SurfacePoint], &[Vec3]),
        count: u32,
        (afar, weight): (&Direction, &Weight),
        stream: Stream,
    ) -> Option<Openings> {
        let from = points.iter().copied().zip(viewers.iter().copied());
        let from: Vec<(SurfacePoint, Vec3)> = from.collect();
        let walks = Walks {
            from: &from,
            count,
            stream,
            index: 0,
        };
        let stack = &mut self.wide.stack();
        Openings::learn(self, walks, afar, weight, stack)
    }

    /// Radiance [W/(sr m²)] that the surface emits at a point toward `v` when `lights` shine.
    pub fn emission_of(&self, lights: &LightSet, point: &SurfacePoint, v: Vec3) -> Vec3 {
        let at = (point.triangle, point.barycentrics);
        lights.emission(self.scene, at, point.normal, v)
    }
}

/// Estimates the radiance [W/(sr m^2)] that points send to their viewers under `illumination`, by
/// unit directions `viewers` (world frame). Point i draws its numbers at index `first_index + i`
/// of `stream`.
///
/// Triangles that emit are found by choosing a point on them by power, the sky by its map, the
/// sun by its disk, and all of them by the path's own directions, weighted by the balance
/// heuristic. Points of light go by [`Estimator`].
pub fn own_light(
    tracer: &Tracer,
    illumination: Illumination,
    points: &[SurfacePoint],
    viewers: &[Vec3],
    sampling: Sampling,
    stream: Stream,
    first_index: u64,
) -> Result<Estimates, TraceError> {
    let lights = vec![Vec3::ZERO; points.len()];
    let queries = Queries {
        points,
        viewers,
        lights: &lights,
    };
    let direct = illumination.reflections == Reflections::One;
    let part = Part {
        tracer,
        source: Source::Set {
            set: illumination.lights,
            connect: !direct && illumination.estimator != Estimator::NextEvent,
        },
        direct,
        broad: false,
        keep: KEEP,
        openings: illumination.lights.openings.as_ref(),
        stream,
    };
    let how = (illumination.estimator, sampling);
    traced(&part, queries, how, first_index)
}

/// Estimates the light of the scene's emitting triangles alone: [`own_light`] without any other.
/// Zero without lamps.
pub fn lamp_light(
    tracer: &Tracer,
    points: &[SurfacePoint],
    viewers: &[Vec3],
    reflections: Reflections,
    sampling: Sampling,
    stream: Stream,
    first_index: u64,
) -> Result<Estimates, TraceError> {
    let illumination = Illumination {
        lights: &tracer.lamps,
        reflections,
        estimator: Estimator::default(),
    };
    own_light(
        tracer,
        illumination,
        points,
        viewers,
        sampling,
        stream,
        first_index,
    )
}

/// Estimates the indirect radiance [W/(sr m^2)] of every query for a sun of 1 W/m² a channel on a
/// plane that faces it, as wide as seen from the earth: `lights` are unit directions toward it.
pub fn sun_light(
    tracer: &Tracer,
    queries: Queries,
    (estimator, sampling): (Estimator, Sampling),
    stream: Stream,
    first_index: u64,
) -> Result<Estimates, TraceError> {
    let part = Part {
        tracer,
        source: Source::Sun,
        direct: false,
        broad: false,
        keep: KEEP,
        openings: None,
        stream,
    };
    traced(&part, queries, (estimator, sampling), first_index)
}

fn traced(
    part: &Part,
    queries: Queries,
    (estimator, sampling): (Estimator, Sampling),
    first_index: u64,
) -> Result<Estimates, TraceError> {
    queries.check()?;
    let each = sampling.each()?;
    let rows: Vec<Row> = queries.rows(sampling.replicates, first_index);
    let values = if part.source.is_dark() {
        vec![Vec3::ZERO; rows.len()]
    } else {
        part.tracer
            .unless_halted(estimator.estimate(part, &rows, each))?
    };
    Ok(Estimates {
        replicates: sampling.replicates as usize,
        values,
    })
}
