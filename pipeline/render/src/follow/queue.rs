//! The rays of a tile that go on from one surface to the next.

use super::carried::Carried;
use super::part::{Brings, FollowedPart};
use crate::direct::SampledLights;
use crate::tile::VisiblePoints;
use rrf_sampling::Stream;
use rrf_trace::{Hits, Rays, Tracer};

/// Throughput from which on a ray is worth its time: a five-hundredth of the camera ray's light.
const LEAST: f32 = 1.0 / 512.0;
/// The largest number that chooses a direction.
const BELOW_ONE: f32 = 1.0 - 0.5 * f32::EPSILON;
/// Fractional part of the golden ratio: its multiples spread evenly.
const GOLDEN: f32 = 0.618_034;

/// Rays, what they carry, and what they meet: parallel columns.
#[derive(Clone, Debug, Default)]
pub(crate) struct RayQueue {
    pub(crate) rays: Rays,
    pub(crate) carried: Vec<Carried>,
    pub(crate) hits: Hits,
}

/// What all rays of a tile share.
pub(crate) struct Launch<'a> {
    pub(crate) tracer: &'a Tracer<'a>,
    pub(crate) lights: &'a SampledLights<'a>,
    pub(crate) stream: Stream,
    /// Number of the tile's first pixel.
    pub(crate) first: u64,
    /// Rays of final gather from each row.
    pub(crate) gather: u32,
}

impl RayQueue {
    /// Forgets all rays and keeps the memory.
    pub(crate) fn clear(&mut self) {
        self.rays.clear();
        self.carried.clear();
    }

    /// Traces the rays.
    pub(crate) fn trace(&mut self, tracer: &Tracer) {
        tracer.closest(&self.rays, &mut self.hits);
    }

    /// Queues the rays of every row that has a followed part, and takes their share from the row's trust.
    /// Random numbers belong to pixels: the same frame has the same ones whenever it is made.
    pub(crate) fn launch(
        &mut self,
        launch: &Launch,
        seen: &mut VisiblePoints,
        parts: &[Option<FollowedPart>],
    ) {
        let mut before = (u32::MAX, 0);
        for row in 0..seen.points.len() {
            let pixel = seen.carried[row].pixel;
            before = (pixel, if pixel == before.0 { before.1 + 1 } else { 0 });
            if let Some(part) = parts.get(row).and_then(Option::as_ref) {
                self.launch_row(launch, seen, row, part, 2 * before.1);
            }
            if launch.gather > 0
                && let Some(part) = FollowedPart::gather(&seen.materials[row], launch.gather)
            {
                self.launch_row(launch, seen, row, &part, 2 * before.1 + 1);
            }
        }
    }

    fn launch_row(
        &mut self,
        launch: &Launch,
        seen: &mut VisiblePoints,
        row: usize,
        part: &FollowedPart,
        sub: u32,
    ) {
        let (point, normal, v) = (seen.points[row], seen.normals[row], seen.viewers[row]);
        let from = seen.carried[row];
        let index = launch.first + u64::from(from.pixel);
        let [shift_0, shift_1, shift_2, _] = launch.stream.units(index, u32::MAX, sub);
        let count = part.rays as f32;
        let level = launch.lights.level_at(point.position, seen.side(row));
        let (begin, mut reflected) = (self.carried.len(), 0.0);
        for ray in 0..part.rays {
            let u = [
                (ray as f32 * GOLDEN + shift_0).fract(),
                ((ray as f32 + shift_1) / count).min(BELOW_ONE),
                (radical_inverse(ray) + shift_2).fract().min(BELOW_ONE),
            ];
            let scattered = part.bsdf.sample(normal, v, part.place(u));
            let throughput = from.throughput * scattered.weight / count;
            let leaves = point.normal.dot(scattered.l) * point.normal.dot(v) > 0.0;
            if !leaves || throughput.max_element() * count < LEAST {
                continue;
            }
            reflected += (scattered.weight.max_element() / count).min(1.0);
            let density = count * scattered.pdf;
            let rival = match part.brings {
                Brings::Surfaces => f32::INFINITY,
                _ if part.is_sharp || level <= 0.0 => 0.0,
                _ => SampledLights::shadow_density(1.0, level) / density,
            };
            let at = point.position;
            self.carried.push(Carried {
                pixel: from.pixel,
                throughput,
                share: scattered.weight.max_element() / count,
                rival,
                far: launch.lights.far_beside_shadow_rays(at, scattered.l, rival),
                surface: part.brings != Brings::Lamps,
            });
            let origin = launch.tracer.lift(point.triangle, at, scattered.l);
            self.rays.push(origin, scattered.l, f32::INFINITY);
        }
        self.share_trust(seen, row, part, begin, reflected.min(1.0));
    }

    /// Hands the share of a row's trust on to its rays: all of it where nothing is left at the row,
    /// otherwise as much as they reflect.
    fn share_trust(
        &mut self,
        seen: &mut VisiblePoints,
        row: usize,
        part: &FollowedPart,
        begin: usize,
        reflected: f32,
    ) {
        let rays = &mut self.carried[begin..];
        let sum: f32 = rays.iter().map(|ray| ray.share).sum();
        let own = seen.carried[row].share;
        let handed = match (part.brings, part.rest) {
            (Brings::Lamps, _) => 0.0,
            (Brings::Surfaces, _) | (Brings::All, None) => own,
            (Brings::All, Some(_)) => own * reflected,
        };
        if sum > 0.0 {
            rays.iter_mut().for_each(|ray| ray.share *= handed / sum);
            seen.carried[row].share = own - handed;
        }
    }
}

/// Van der Corput's sequence.
fn radical_inverse(index: u32) -> f32 {
    (index.reverse_bits() >> 8) as f32 / (1 << 24) as f32
}
