//! The pilot of a query: walks that look where light from afar comes in.

use super::emit::{Group, Lights};
use super::openings::{Openings, Seen};
use crate::rays;
use crate::surface::Site;
use crate::tracer::Tracer;
use crate::walk::{Found, Ray, Stack};
use crate::wave::Row;
use glam::Vec3;
use rrf_lights::about;
use rrf_materials::{INVALID, cosine_hemisphere};
use rrf_sampling::Stream;

/// Vertices of a walk that look outside.
const VERTICES: u32 = 4;
/// The part of a stream that walks draw from.
const PART: u32 = 0x6f70_656e;

/// A walk's end so far.
struct Walker {
    number: u32,
    origin: Vec3,
    direction: Vec3,
}

impl Openings {
    /// Learns where light comes in that reaches a row's point, by `walks` walks; none if nothing does.
    pub(super) fn learn(
        (tracer, lights): (&Tracer, &Lights),
        row: &Row,
        (walks, stream): (u32, Stream),
        stack: &mut Stack,
    ) -> Option<Openings> {
        let mut seen = Seen::new(tracer.bounds);
        let stream = stream.part(PART);
        let mut hits: Vec<Found> = Vec::new();
        let mut blocked = Vec::new();
        // the first vertex is the row's own point
        let mut places: Vec<(u32, Site, Vec3)> = Vec::new();
        let first = tracer.site(row.point.triangle, row.point.barycentrics);
        places.extend((0..walks).map(|number| (number, first, row.viewer)));
        for vertex in 0..VERTICES {
            let (mut rays, mut walkers) = (Vec::new(), Vec::new());
            let (mut shadows, mut arriving) = (Vec::new(), Vec::new());
            for (number, site, v) in &places {
                let at = site.seen_from(*v);
                let u = stream.units(row.index, *number, 2 * vertex);
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
                let w = stream.units(row.index, *number, 2 * vertex + 1);
                let end = lights.end(Group::Far, None, [w[0], w[1], w[2]]);
                if let Some(end) = end.filter(|end| at.geometric.dot(end.at) > 0.0) {
                    let origin = site.origin(end.at);
                    shadows.push(Ray {
                        origin,
                        direction: end.at,
                        t_max: f32::INFINITY,
                    });
                    arriving.push(f64::from(at.geometric.dot(end.at)));
                }
            }
            rays::occluded(&tracer.wide, &shadows, stack, &mut blocked);
            for ((ray, weight), blocked) in shadows.iter().zip(&arriving).zip(&blocked) {
                if !blocked {
                    seen.add(1, ray.origin, ray.direction, *weight);
                }
            }
            rays::closest(&tracer.wide, &rays, stack, &mut hits);
            places.clear();
            for (walker, hit) in walkers.iter().zip(&hits) {
                if hit.triangle == INVALID {
                    seen.add(0, walker.origin, walker.direction, 1.0);
                } else {
                    let site = tracer.site(hit.triangle, hit.barycentrics);
                    places.push((walker.number, site, -walker.direction));
                }
            }
        }
        seen.openings()
    }
}
