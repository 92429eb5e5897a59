//! Lights from afar that nothing lets in.

use crate::rays::{Hits, Rays};
use crate::tracer::Tracer;
use glam::Vec3;
use rrf_lights::{LightSource, uniform_sphere};
use rrf_sampling::Stream;
use rrf_scene::INVALID;

/// Rays from all eyes together.
const RAYS: usize = 4096;

/// Reflections that are followed.
const REFLECTIONS: u32 = 3;

/// A path's end so far.
#[derive(Clone, Copy)]
struct Place {
    path: u64,
    origin: Vec3,
    direction: Vec3,
}

impl Tracer<'_> {
    /// Whether each of `sources` lights a surface that the `eyes` see, or one that is seen by way
    /// of up to three reflections, as far as some thousand paths can tell. All directions count
    /// alike, whatever a surface reflects.
    pub fn reached(&self, eyes: &[Vec3], sources: &[&LightSource], stream: Stream) -> Vec<bool> {
        let mut reached = vec![false; sources.len()];
        let each = RAYS / eyes.len().max(1);
        let start = |k: usize| {
            let [a, b, ..] = stream.units(k as u64, 0, 0);
            Some(Place {
                path: k as u64,
                origin: *eyes.get(k / each.max(1))?,
                direction: uniform_sphere([a, b]),
            })
        };
        let mut places: Vec<Place> = (0..RAYS).filter_map(start).collect();
        let mut hits = Hits::default();
        for bounce in 1..=REFLECTIONS + 1 {
            let mut rays = Rays::default();
            let push = |p: &Place| rays.push(p.origin, p.direction, f32::INFINITY);
            places.iter().for_each(push);
            self.closest(&rays, &mut hits);
            places = self.follow(&places, &hits, bounce, sources, &mut reached, stream);
            if reached.iter().all(|&reached| reached) {
                break;
            }
        }
        reached
    }

    /// Looks for the lights from where rays ended; the rays that go on from there.
    fn follow(
        &self,
        places: &[Place],
        hits: &Hits,
        bounce: u32,
        sources: &[&LightSource],
        reached: &mut [bool],
        stream: Stream,
    ) -> Vec<Place> {
        let (mut next, mut shadows, mut sought) = (Vec::new(), Rays::default(), Vec::new());
        let columns = hits.triangle.iter().zip(&hits.barycentrics);
        for (place, (&triangle, &barycentrics)) in places.iter().zip(columns) {
            if triangle == INVALID {
                for (reached, source) in reached.iter_mut().zip(sources) {
                    *reached |= source.radiance(place.direction) != Vec3::ZERO;
                }
                continue;
            }
            let point = self.point(triangle, barycentrics);
            let facing = point.normal.dot(place.direction) < 0.0;
            let normal = if facing { point.normal } else { -point.normal };
            for (k, source) in sources.iter().enumerate() {
                let [a, b, ..] = stream.units(place.path, bounce, 1 + k as u32);
                let arrival = source.sample(point.position, [a, b]);
                let arrival = arrival.filter(|a| a.toward.dot(normal) > 0.0);
                if let Some(arrival) = arrival.filter(|_| !reached[k]) {
                    let origin = self.lift(triangle, point.position, normal);
                    shadows.push(origin, arrival.toward, arrival.distance);
                    sought.push(k);
                }
            }
            let [a, b, ..] = stream.units(place.path, bounce, 0);
            let direction = (normal + uniform_sphere([a, b])).try_normalize();
            next.push(Place {
                path: place.path,
                origin: self.lift(triangle, point.position, normal),
                direction: direction.unwrap_or(normal),
            });
        }
        let mut blocked = Vec::new();
        self.occluded(&shadows, &mut blocked);
        for (source, blocked) in sought.into_iter().zip(blocked) {
            reached[source] |= !blocked;
        }
        next
    }
}
