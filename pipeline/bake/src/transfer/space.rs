//! The free space that eyes can come to, and what they see of the surface.

use crate::error::BakeError;
use glam::Vec3;
use rayon::prelude::*;
use rrf_extract::{ExtractError, NarrowLight, Region, VisibilityQueries};
use rrf_lights::uniform_sphere;
use rrf_sampling::{Stage, Stream};
use rrf_scene::{INVALID, Scene};
use rrf_trace::{Hits, Rays, SurfacePoint, Tracer};
use rrf_transfer::{PointDraw, RowPoint};

/// Places that eyes look from, at most.
const PLACES: usize = 256;
/// Places that are tried.
const TRIED: u64 = 8_192;
/// Places that look at another one at a time: most are seen by one of the first.
const AT_ONCE: usize = 16;
/// Rays of a place that tell whether it is enclosed.
const LOOKS: u32 = 64;
/// Places that may be where a scene without cameras is looked at from.
const STARTS: u64 = 64;
/// Viewers at a smaller cosine see nothing to speak of.
const GRAZING: f32 = 0.02;
/// Camera rays that are drawn together.
const BATCH: usize = 4_096;

/// Places in the free space that cameras stand in.
pub(super) struct FreeSpace<'a> {
    tracer: &'a Tracer<'a>,
    places: Vec<Vec3>,
    narrow: NarrowLight,
    stream: Stream,
}

impl<'a> FreeSpace<'a> {
    /// Grown from the cameras through what they see; from the most enclosed place where there is
    /// none; or the eye box.
    ///
    /// # Errors
    /// [`BakeError::Extract`] where no place is free.
    pub(super) fn new(
        scene: &Scene,
        tracer: &'a Tracer<'a>,
        (eye_box, narrow): (Option<Region>, NarrowLight),
        seed: u64,
    ) -> Result<FreeSpace<'a>, BakeError> {
        let bounds = scene.bounds().ok_or(ExtractError::NoTriangle)?;
        let whole = Region {
            minimum: bounds.min,
            maximum: bounds.max,
        };
        let visibility = VisibilityQueries::new(scene, tracer);
        let mut space = FreeSpace {
            tracer,
            places: Vec::new(),
            narrow,
            stream: Stream::new(seed, Stage::Transfer, 4),
        };
        let region = eye_box.unwrap_or(whole);
        let draws = space.stream.part(0);
        let draw = |i: u64| {
            let [x, y, z, _] = draws.units(i, 0, 0);
            region.at([x, y, z])
        };
        if eye_box.is_some() {
            let free = |place: &Vec3| !visibility.inside_solid(*place);
            let places = (0..TRIED).map(draw).filter(free).take(PLACES);
            space.places = places.collect();
        } else {
            let eyes = scene.cameras.iter().map(|camera| camera.eye);
            let eyes: Vec<Vec3> = eyes.filter(|&eye| !visibility.inside_solid(eye)).collect();
            space.places = match eyes.is_empty() {
                false => eyes,
                true => space.enclosed(&visibility, (0..STARTS).map(draw)),
            };
            for i in 0..TRIED {
                let place = draw(i);
                if space.places.len() < PLACES && space.is_free(place) {
                    space.places.push(place);
                }
            }
        }
        if space.places.is_empty() {
            return Err(ExtractError::Box {
                what: "eye",
                bounds: region,
                message: "lies inside solids: no eye can be in it".into(),
            }
            .into());
        }
        Ok(space)
    }

    /// The tracer of the scene without its own lights.
    pub(super) fn tracer(&self) -> &'a Tracer<'a> {
        self.tracer
    }

    /// The place from which most rays meet a surface, the farthest of them; none where all are
    /// inside solids.
    fn enclosed(
        &self,
        visibility: &VisibilityQueries,
        places: impl Iterator<Item = Vec3>,
    ) -> Vec<Vec3> {
        let (mut rays, mut hits) = (Rays::default(), Hits::default());
        let directions = self.stream.part(2);
        let mut best: Option<(u32, f32, Vec3)> = None;
        for place in places.filter(|&place| !visibility.inside_solid(place)) {
            rays.clear();
            for i in 0..LOOKS {
                let u = directions.units(u64::from(i), 0, 0);
                rays.push(place, uniform_sphere([u[0], u[1]]), f32::INFINITY);
            }
            self.tracer.closest(&rays, &mut hits);
            let (mut met, mut far) = (0, 0.0);
            for (&triangle, &barycentrics) in hits.triangle.iter().zip(&hits.barycentrics) {
                if triangle != INVALID {
                    met += 1;
                    far += self
                        .tracer
                        .point(triangle, barycentrics)
                        .position
                        .distance(place);
                }
            }
            // three in four are as good as all: a room may have a door
            let met = met.min(3 * LOOKS / 4);
            if best.is_none_or(|(other, way, _)| (met, far) > (other, way)) {
                best = Some((met, far, place));
            }
        }
        best.into_iter().map(|best| best.2).collect()
    }

    /// Whether a place is seen from one of the space.
    pub(super) fn is_free(&self, place: Vec3) -> bool {
        let (mut rays, mut blocked) = (Rays::default(), Vec::new());
        self.places.chunks(AT_ONCE).any(|places| {
            rays.clear();
            for &from in places {
                rays.push(from, place - from, 1.0);
            }
            self.tracer.occluded(&rays, &mut blocked);
            blocked.contains(&false)
        })
    }

    /// Whether a surface sends no light that a model answers for.
    fn is_dark(&self, point: &SurfacePoint) -> bool {
        let material = self.tracer.material_at(point);
        match self.narrow {
            NarrowLight::Learned => material.is_black(),
            NarrowLight::Traced => material.broad().is_none_or(|broad| broad.is_black()),
        }
    }

    /// A place by a number in [0, 1).
    pub(super) fn place(&self, u: f32) -> Vec3 {
        let index = (u * self.places.len() as f32) as usize;
        self.places[index.min(self.places.len() - 1)]
    }

    /// What the eyes see by some numbers of the sequence.
    fn seen(&self, first: u64, count: usize) -> Vec<RowPoint> {
        let (mut rays, mut hits) = (Rays::default(), Hits::default());
        let stream = self.stream.part(1);
        for i in first..first + count as u64 {
            let u = stream.units(i, 0, 0);
            let eye = self.place(u[0]);
            rays.push(eye, uniform_sphere([u[1], u[2]]), f32::INFINITY);
        }
        self.tracer.closest(&rays, &mut hits);
        let row = |i: usize| {
            let point = self.tracer.point(hits.triangle[i], hits.barycentrics[i]);
            let viewer = -rays.direction[i];
            let is_grazing = point.normal.dot(viewer).abs() <= GRAZING;
            let is_dark = || self.is_dark(&point);
            (!is_grazing && !is_dark()).then_some(RowPoint { point, viewer })
        };
        let met = (0..count).filter(|&i| hits.triangle[i] != INVALID);
        met.filter_map(row).collect()
    }
}

impl PointDraw for FreeSpace<'_> {
    fn draw(&self, first: u64, count: usize) -> Vec<RowPoint> {
        let batches = (0..count.div_ceil(BATCH)).into_par_iter();
        let seen: Vec<Vec<RowPoint>> = batches
            .map(|batch| {
                if self.tracer.is_halted() {
                    return Vec::new();
                }
                let from = batch * BATCH;
                self.seen(first + from as u64, BATCH.min(count - from))
            })
            .collect();
        seen.concat()
    }
}
