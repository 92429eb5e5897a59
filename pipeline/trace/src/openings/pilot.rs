//! The pilot: walks that look where light from afar comes in.

use super::{Openings, Seen};
use crate::rays;
use crate::surface::{Site, SurfacePoint};
use crate::tracer::Tracer;
use crate::walk::{Found, Ray, Stack};
use glam::Vec3;
use rrf_lights::about;
use rrf_materials::{INVALID, cosine_hemisphere};
use rrf_sampling::Stream;

/// Vertices of a walk that look outside.
const VERTICES: u32 = 4;
/// The part of a stream that walks draw from.
const PART: u32 = 0x6f70_656e;
/// First of the blocks that say what rays pass.
const PASS: u32 = 1 << 26;
const PASSES: u32 = 256;

/// Walks that begin at some points, evenly.
#[derive(Clone, Copy)]
pub(crate) struct Walks<'a> {
    /// The points, and unit directions to their viewers.
    pub(crate) from: &'a [(SurfacePoint, Vec3)],
    /// How many.
    pub(crate) count: u32,
    /// Where they draw their numbers, at this index.
    pub(crate) stream: Stream,
    pub(crate) index: u64,
}

/// A walk's end so far.
struct Walker {
    number: u32,
    origin: Vec3,
    direction: Vec3,
}

impl Openings {
    /// Learns where light comes in that reaches some points; none if nothing does. `afar` draws the
    /// direction to a light from afar, by three numbers in [0, 1); `weight` says how much a direction matters that
    /// a walk leaves in.
    pub(crate) fn learn(
        tracer: &Tracer,
        walks: Walks,
        afar: &dyn Fn([f32; 3]) -> Option<Vec3>,
        weight: &dyn Fn(Vec3) -> f32,
        stack: &mut Stack,
    ) -> Option<Openings> {
        let mut seen = Seen::new(tracer.bounds);
        let (stream, index) = (walks.stream.part(PART), walks.index);
        let mut hits: Vec<Found> = Vec::new();
        let mut beyond: Vec<Found> = Vec::new();
        let mut blocked = Vec::new();
        let begin = |number: u32| {
            let place = number as usize * walks.from.len() / walks.count as usize;
            let (point, viewer) = walks.from.get(place)?;
            let site = tracer.site(point.triangle, point.barycentrics);
            Some((number, site, *viewer))
        };
        let mut places: Vec<(u32, Site, Vec3)> = (0..walks.count).filter_map(begin).collect();
        for vertex in 0..VERTICES {
            let (mut rays, mut walkers) = (Vec::new(), Vec::new());
            let (mut shadows, mut arriving) = (Vec::new(), Vec::new());
            for (number, site, v) in &places {
                let at = site.seen_from(*v);
                let u = stream.units(index, *number, 2 * vertex);
                let direction = about(at.geometric, cosine_hemisphere([u[0], u[1]]));
                let origin = site.origin(direction);
                rays.push(Ray {
                    origin,
                    direction,
                    t_max: f32::INFINITY,
                });
                walkers.push(Walker {
                    number: *number,
                    origin,
                    direction,
                });
                let w = stream.units(index, *number, 2 * vertex + 1);
                let toward = afar([w[0], w[1], w[2]]);
                if let Some(toward) = toward.filter(|&l| at.geometric.dot(l) > 0.0) {
                    let origin = site.origin(toward);
                    shadows.push(Ray {
                        origin,
                        direction: toward,
                        t_max: f32::INFINITY,
                    });
                    arriving.push(f64::from(at.geometric.dot(toward)));
                }
            }
            rays::occluded(&tracer.wide, &shadows, stack, &mut blocked);
            for ((ray, weight), blocked) in shadows.iter().zip(&arriving).zip(&blocked) {
                let share = match (blocked, tracer.passes) {
                    (false, _) => 1.0,
                    (true, false) => 0.0,
                    (true, true) => tracer.transmittance(ray, stack, &mut beyond).max_element(),
                };
                seen.draw(ray.origin, ray.direction, *weight, share.into());
            }
            rays::closest(&tracer.wide, &rays, stack, &mut hits);
            places.clear();
            for ((walker, ray), hit) in walkers.iter().zip(&rays).zip(&mut hits) {
                if tracer.passes {
                    let first = PASS + vertex * PASSES;
                    tracer.pass_by_chance(ray, hit, stack, &mut beyond, |k| {
                        stream.units(index, walker.number, first + k)[0]
                    });
                }
                if hit.triangle == INVALID {
                    let weight = weight(walker.direction);
                    seen.leave(walker.origin, walker.direction, weight.into());
                } else {
                    let site = tracer.site(hit.triangle, hit.barycentrics);
                    places.push((walker.number, site, -walker.direction));
                }
            }
        }
        seen.openings()
    }
}
