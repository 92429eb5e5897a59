//! The rays of a tile that go on from one surface to the next.

use super::carried::{Carried, Lit};
use super::part::{Brings, FollowedPart};
use super::patches::MetPatches;
use crate::direct::SampledLights;
use crate::tile::VisiblePoints;
use glam::Vec3;
use rrf_sampling::Stream;
use rrf_trace::{Hits, Rays, SurfacePoint, Tracer};

/// Throughput from which on a ray is worth its time: a five-hundredth of the camera ray's light, or a quarter
/// of one ray's share where many are gathered.
pub(crate) fn least(gathered: u32) -> f32 {
    1.0 / (4 * gathered.max(128)) as f32
}
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
    /// Pixel and share of trust of rows that are gathered over and that no ray left: nothing comes there.
    pub(crate) settled: Vec<(u32, f32)>,
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

/// How the rays of a row are shared out between its own lobes and bright patches.
#[derive(Clone, Copy)]
struct Split {
    own: u32,
    bright: u32,
    /// Mean of either over all choices.
    expected: [f32; 2],
}

impl Split {
    /// All for the row's own lobes.
    fn own(rays: u32) -> Split {
        Split {
            own: rays,
            bright: 0,
            expected: [rays as f32, 0.0],
        }
    }

    /// Half and half, if bright patches are known; a single ray goes either way by chance.
    fn of(launch: &Launch, rays: u32, (pixel, sub): (u32, u32)) -> Split {
        if launch.bright.is_none() {
            return Split::own(rays);
        }
        if rays == 1 {
            let index = launch.first + u64::from(pixel);
            let chance = launch.stream.units(index, u32::MAX - 2, sub)[0];
            let bright = u32::from(chance < 0.5);
            return Split {
                own: 1 - bright,
                bright,
                expected: [0.5; 2],
            };
        }
        let bright = rays / 2;
        Split {
            own: rays - bright,
            bright,
            expected: [(rays - bright) as f32, bright as f32],
        }
    }
}

/// What all rays of a tile share.
pub(crate) struct Launch<'a> {
    pub(crate) tracer: &'a Tracer<'a>,
    pub(crate) lights: &'a SampledLights<'a>,
    pub(crate) stream: Stream,
    /// Number of the tile's first pixel.
    pub(crate) first: u64,
    /// Where half of the rays that gather light go, if that is known.
    pub(crate) bright: Option<&'a MetPatches<'a>>,
    /// Throughput from which on a ray is worth its time.
    pub(crate) least: f32,
}

impl RayQueue {
    /// Forgets all rays and keeps the memory.
    pub(crate) fn clear(&mut self) {
        self.rays.clear();
        self.carried.clear();
        self.settled.clear();
    }

    /// Traces the rays.
    pub(crate) fn trace(&mut self, tracer: &Tracer) {
        tracer.closest(&self.rays, &mut self.hits);
    }

    /// Queues the rays of every row that has a followed part, and those of `gathered` rows, by their
    /// numbers, from their broad parts. Takes the rays' share from the row's trust.
    /// Random numbers belong to pixels: the same frame has the same ones whenever it is made.
    pub(crate) fn launch(
        &mut self,
        launch: &Launch,
        seen: &mut VisiblePoints,
        parts: &[Option<FollowedPart>],
        gathered: &[u32],
    ) {
        let mut before = (u32::MAX, 0);
        for row in 0..seen.points.len() {
            let pixel = seen.carried[row].pixel;
            before = (pixel, if pixel == before.0 { before.1 + 1 } else { 0 });
            if let Some(part) = parts.get(row).and_then(Option::as_ref) {
                self.launch_row(
                    launch,
                    seen,
                    row,
                    part,
                    (2 * before.1, Split::own(part.rays)),
                );
            }
            let rays = gathered.get(row).copied().unwrap_or(0);
            if rays > 0
                && let Some(part) = FollowedPart::gather(&seen.materials[row], rays)
            {
                let sub = 2 * before.1 + 1;
                let split = Split::of(launch, rays, (seen.carried[row].pixel, sub));
                self.launch_row(launch, seen, row, &part, (sub, split));
            }
        }
    }

    fn launch_row(
        &mut self,
        launch: &Launch,
        seen: &mut VisiblePoints,
        row: usize,
        part: &FollowedPart,
        (sub, split): (u32, Split),
    ) {
        let begin = self.carried.len();
        let start = Departure {
            point: seen.points[row],
            normal: seen.normals[row],
            viewer: seen.viewers[row],
            level: match part.brings_emission() {
                true => (launch.lights).level_at(seen.points[row].position, seen.side(row)),
                false => 0.0,
            },
            from: seen.carried[row],
        };
        if let Some(reflects) = part.branch(start.normal, start.viewer) {
            let refracts = 1.0 - reflects;
            let middles = [0.5 * reflects, reflects + 0.5 * refracts];
            let ends = middles.map(|lobe| ([lobe, 0.0, 0.0], 0.0));
            self.send(launch, part, &start, ends[0], reflects);
            self.send(launch, part, &start, ends[1], refracts);
        } else {
            let index = launch.first + u64::from(start.from.pixel);
            let [shift_0, shift_1, shift_2, shift_3] = launch.stream.units(index, u32::MAX, sub);
            let count = split.own as f32;
            for ray in 0..split.own {
                let u = [
                    (ray as f32 * GOLDEN + shift_0).fract(),
                    ((ray as f32 + shift_1) / count).min(BELOW_ONE),
                    (radical_inverse(ray) + shift_2).fract().min(BELOW_ONE),
                ];
                let lives = (ray as f32 * GOLDEN + shift_3).fract();
                self.send(launch, part, &start, (u, lives), 1.0 / split.expected[0]);
            }
        }
        for ray in &mut self.carried[begin..] {
            ray.guide *= split.expected[1];
        }
        if split.own > 0 {
            self.share_trust(seen, row, part, begin);
        }
        self.aim(launch, part, &start, (sub, split));
        if split.own == 0 {
            self.share_trust(seen, row, part, begin);
        }
    }

    /// Queues a ray by the numbers that choose it and whether it goes on at all; it stands for `share`
    /// of the part.
    fn send(
        &mut self,
        launch: &Launch,
        part: &FollowedPart,
        start: &Departure,
        (u, lives): ([f32; 3], f32),
        share: f32,
    ) {
        let (point, v, from) = (&start.point, start.viewer, &start.from);
        let u = part.place(u);
        let scattered = part.bsdf.sample(start.normal, v, u);
        let toward = scattered.l;
        // light through a surface by one of its normals alone does not count
        let reflects = point.normal.dot(toward) * point.normal.dot(v) > 0.0;
        let agrees = reflects == (start.normal.dot(toward) > 0.0);
        if !agrees || scattered.pdf <= 0.0 {
            return;
        }
        let mut whole = from.throughput * scattered.weight;
        let worth = whole.max_element() * share.max(0.1) / launch.least;
        if worth < 1.0 {
            // Russian roulette where a net does not stand for the light (Arvo and Kirk 1990)
            if part.brings != Brings::Surfaces || lives >= worth {
                return;
            }
            whole /= worth;
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
            lit: match part.brings {
                Brings::Surfaces => Lit::Widened,
                _ => Lit::Whole,
            },
            guide: share / scattered.pdf,
            target: 0.0,
            length: 0.0,
        });
        let origin = (launch.tracer).lift(point.triangle, point.position, toward);
        self.rays.push(origin, toward, f32::INFINITY);
    }

    /// Queues rays to bright patches. Those and the part's own share the light by the balance heuristic
    /// (Veach and Guibas 1995).
    fn aim(
        &mut self,
        launch: &Launch,
        part: &FollowedPart,
        start: &Departure,
        (sub, split): (u32, Split),
    ) {
        let count = split.bright;
        let Some(places) = launch.bright else { return };
        let (point, from) = (&start.point, &start.from);
        let index = launch.first + u64::from(from.pixel);
        let shifts = launch.stream.units(index, u32::MAX - 1, sub);
        for ray in 0..count {
            let u = [
                ((ray as f32 + shifts[0]) / count as f32).min(BELOW_ONE),
                (radical_inverse(ray) + shifts[1]).fract().min(BELOW_ONE),
                (ray as f32 * GOLDEN + shifts[2]).fract().min(BELOW_ONE),
            ];
            let Some(target) = places.sample(launch.tracer, point.position, u) else {
                continue;
            };
            let toward = target.toward;
            let value = part.bsdf.eval(start.normal, start.viewer, toward);
            let reflects = point.normal.dot(toward) * point.normal.dot(start.viewer) > 0.0;
            if value == Vec3::ZERO || reflects != (start.normal.dot(toward) > 0.0) {
                continue;
            }
            let own = part.bsdf.pdf(start.normal, start.viewer, toward);
            let [own_rays, bright_rays] = split.expected;
            let both = own_rays * own + bright_rays * target.density;
            self.carried.push(Carried {
                pixel: from.pixel,
                throughput: from.throughput * value / both,
                // its trust is lost or won by the row's own rays, if it has any
                share: if split.own == 0 { 1.0 } else { 0.0 },
                rival: f32::INFINITY,
                far: Vec3::ZERO,
                surface: true,
                lit: Lit::Widened,
                guide: 0.0,
                target: target.distance,
                length: 0.0,
            });
            let origin = (launch.tracer).lift(point.triangle, point.position, toward);
            self.rays.push(origin, toward, f32::INFINITY);
        }
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
            (_, None) => own,
            (_, Some(_)) => own * sum.min(1.0),
        };
        if sum > 0.0 {
            rays.iter_mut().for_each(|ray| ray.share *= handed / sum);
            seen.carried[row].share = own - handed;
        } else if part.brings == Brings::Surfaces && part.rest.is_none() {
            self.settled.push((seen.carried[row].pixel, own));
            seen.carried[row].share = 0.0;
        }
    }
}

/// Van der Corput's sequence.
fn radical_inverse(index: u32) -> f32 {
    (index.reverse_bits() >> 8) as f32 / (1 << 24) as f32
}
