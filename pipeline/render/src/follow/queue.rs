//! The rays of a tile that go on from one surface to the next.

use super::carried::Carried;
use super::part::{Brings, FollowedPart};
use crate::direct::SampledLights;
use crate::tile::VisiblePoints;
use glam::Vec3;
use rrf_sampling::Stream;
use rrf_trace::{Hits, Rays, SurfacePoint, Tracer};

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

/// Where a row's rays start.
struct Departure {
    point: SurfacePoint,
    normal: Vec3,
    viewer: Vec3,
    /// Light that could arrive there.
    level: f32,
    from: Carried,
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
        let begin = self.carried.len();
        let start = Departure {
            point: seen.points[row],
            normal: seen.normals[row],
            viewer: seen.viewers[row],
            level: launch
                .lights
                .level_at(seen.points[row].position, seen.side(row)),
            from: seen.carried[row],
        };
        if let Some(reflects) = part.branch(start.normal, start.viewer) {
            let refracts = 1.0 - reflects;
            let middles = [0.5 * reflects, reflects + 0.5 * refracts];
            self.send(launch, part, &start, (middles[0], [0.0; 2]), reflects);
            self.send(launch, part, &start, (middles[1], [0.0; 2]), refracts);
        } else {
            let index = launch.first + u64::from(start.from.pixel);
            let [shift_0, shift_1, shift_2, _] = launch.stream.units(index, u32::MAX, sub);
            let count = part.rays as f32;
            for ray in 0..part.rays {
                let place = [
                    ((ray as f32 + shift_1) / count).min(BELOW_ONE),
                    (radical_inverse(ray) + shift_2).fract().min(BELOW_ONE),
                ];
                let lobe = (ray as f32 * GOLDEN + shift_0).fract();
                self.send(launch, part, &start, (lobe, place), 1.0 / count);
            }
        }
        self.share_trust(seen, row, part, begin);
    }

    /// Queues a ray by the numbers that choose it; it stands for `share` of the part.
    fn send(
        &mut self,
        launch: &Launch,
        part: &FollowedPart,
        start: &Departure,
        (lobe, place): (f32, [f32; 2]),
        share: f32,
    ) {
        let (point, v, from) = (&start.point, start.viewer, &start.from);
        let u = part.place([lobe, place[0], place[1]]);
        let scattered = part.bsdf.sample(start.normal, v, u);
        let toward = scattered.l;
        // light through a surface by one of its normals alone does not count
        let reflects = point.normal.dot(toward) * point.normal.dot(v) > 0.0;
        let agrees = reflects == (start.normal.dot(toward) > 0.0);
        let whole = from.throughput * scattered.weight;
        if !agrees || scattered.pdf <= 0.0 || whole.max_element() * share.max(0.1) < LEAST {
            return;
        }
        let rival = match part.brings {
            Brings::Surfaces => f32::INFINITY,
            _ if part.is_sharp || start.level <= 0.0 => 0.0,
            _ => SampledLights::shadow_density(1.0, start.level) * share / scattered.pdf,
        };
        self.carried.push(Carried {
            pixel: from.pixel,
            throughput: whole * share,
            share: scattered.weight.max_element() * share,
            rival,
            far: (launch.lights).far_beside_shadow_rays(point.position, toward, rival),
            surface: part.brings != Brings::Lamps,
        });
        let origin = (launch.tracer).lift(point.triangle, point.position, toward);
        self.rays.push(origin, toward, f32::INFINITY);
    }

    /// Hands the share of a row's trust on to its rays: all of it where nothing is left at the row,
    /// otherwise as much as they reflect.
    fn share_trust(
        &mut self,
        seen: &mut VisiblePoints,
        row: usize,
        part: &FollowedPart,
        begin: usize,
    ) {
        let rays = &mut self.carried[begin..];
        let sum: f32 = rays.iter().map(|ray| ray.share).sum();
        let own = seen.carried[row].share;
        let handed = match (part.brings, part.rest) {
            (Brings::Lamps, _) => 0.0,
            (Brings::Surfaces, _) | (Brings::All, None) => own,
            (Brings::All, Some(_)) => own * sum.min(1.0),
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
