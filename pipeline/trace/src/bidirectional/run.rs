//! One thread's paths.

use super::connect::{Joint, connect, next_event};
use super::emit::{End, Lights};
use super::eye::EyeVertex;
use super::light::LightVertex;
use crate::media::Media;
use crate::rays;
use crate::tracer::Tracer;
use crate::walk::{Found, Ray, Stack};
use crate::wave::{Part, Row};
use glam::{DVec3, Vec3};
use rrf_materials::INVALID;
use rrf_sampling::Stream;
use rrf_sampling::sobol::{self, DIMENSIONS, Scramble, Table};
use std::ops::Range;

/// The part of a stream that these paths draw from.
const PART: u32 = 0x6264_7074;

/// Blocks of numbers a bounce.
pub(super) const BLOCKS: u32 = 16;
/// First blocks of the choices of a light, of the ends and places that mirrors show, and of light
/// subpaths: one a group.
const CHOICE: u32 = 1;
const MIRRORED: u32 = 4;
const PLACE: u32 = 7;
const ONWARD: u32 = 10;

/// First of the blocks that say what rays pass: of paths, of light subpaths, of looks at mirrors; 256 surfaces
/// a ray.
pub(super) const PASS: u32 = 1 << 26;
const PASS_LIGHT: u32 = 2 << 26;
const PASS_LOOKS: u32 = 3 << 26;
pub(super) const PASSES: u32 = 256;

/// First dimensions of what is evenly spread: two directions, where light subpaths begin, and where they go.
const ENDS: usize = 6;
const LEAVING: usize = 9;

/// Working memory of one thread.
pub(super) struct Joined {
    pub(super) rays: Vec<Ray>,
    pub(super) hits: Vec<Found>,
    pub(super) stack: Stack,
    /// Hits of one ray beyond a surface that it passes.
    pub(super) beyond: Vec<Found>,
    pub(super) light_vertices: Vec<LightVertex>,
    pub(super) eyes: Vec<EyeVertex>,
    shadows: Vec<Ray>,
    arriving: Vec<(u32, Vec3)>,
    blocked: Vec<bool>,
    /// Rays to mirrors: vertex, end, and which mirror.
    looking: Vec<(usize, End, u8)>,
    looks: Vec<Ray>,
    pub(super) sums: Vec<Vec3>,
}

/// Where a path draws its numbers.
pub(super) struct Draws<'a> {
    stream: Stream,
    row: &'a Row,
    numbers: Range<usize>,
    each: usize,
    table: &'a Table,
    /// Of the path, and of each group of lights as they begin and as mirrors show them.
    pub(super) scrambles: [Scramble; DIMENSIONS],
    by_group: [[[Scramble; DIMENSIONS]; 2]; 3],
}

impl Draws<'_> {
    /// Independent numbers.
    pub(super) fn block(&self, path: u32, block: u32) -> [f32; 4] {
        let number = self.row.replicate as usize * self.each + self.numbers.start + path as usize;
        self.stream.units(self.row.index, number as u32, block)
    }

    /// Numbers that are evenly spread among the paths of a replicate.
    pub(super) fn spread(
        &self,
        path: u32,
        scrambles: &[Scramble; DIMENSIONS],
        first: usize,
    ) -> [f32; 3] {
        let point = self.table.reversed(self.numbers.start + path as usize);
        std::array::from_fn(|d| sobol::scramble(point[first + d], scrambles[first + d]))
    }
}

fn three([a, b, c, _]: [f32; 4]) -> [f32; 3] {
    [a, b, c]
}

impl Joined {
    pub(super) fn new(tracer: &Tracer) -> Joined {
        Joined {
            rays: Vec::new(),
            hits: Vec::new(),
            stack: tracer.wide.stack(),
            beyond: Vec::new(),
            light_vertices: Vec::new(),
            eyes: Vec::new(),
            shadows: Vec::new(),
            arriving: Vec::new(),
            blocked: Vec::new(),
            looking: Vec::new(),
            looks: Vec::new(),
            sums: Vec::new(),
        }
    }

    /// The sum of some of a row's paths, by their numbers in the replicate of `each`.
    pub(super) fn run(
        &mut self,
        (part, lights): (&Part, &Lights),
        row: &Row,
        numbers: Range<usize>,
        (each, table): (usize, &Table),
    ) -> DVec3 {
        let tracer = part.tracer;
        let stream = part.stream.part(PART);
        let scrambles = |part: u32| sobol::scrambles(stream.part(part), row.index, row.replicate);
        let draws = Draws {
            stream,
            row,
            numbers: numbers.clone(),
            each,
            table,
            scrambles: scrambles(0),
            by_group: [[1, 2], [3, 4], [5, 6]].map(|parts| parts.map(scrambles)),
        };
        self.sums.clear();
        self.sums.resize(numbers.len(), Vec3::ZERO);
        self.begin_light(tracer, lights, &draws);
        let site = tracer.site(row.point.triangle, row.point.barycentrics);
        self.eyes.clear();
        self.eyes
            .extend((0..numbers.len() as u32).map(|path| EyeVertex {
                path,
                triangle: row.point.triangle,
                site,
                viewer: row.viewer,
                throughput: Vec3::ONE,
                media: Media::NONE,
                first: 1.0,
                number: 0,
                density: 0.0,
                back: 0.0,
                before: 0.0,
                from: Vec3::ZERO,
                others: 0.0,
            }));
        while !self.eyes.is_empty() {
            self.shadows.clear();
            self.arriving.clear();
            self.join(tracer, lights, &draws);
            if tracer.mirrors.has_any() {
                self.look_at_mirrors(tracer, lights, &draws);
            }
            self.gather(tracer);
            self.travel(part, lights, &draws);
        }
        self.sums.iter().map(|v| v.as_dvec3()).sum()
    }

    /// Light subpaths of all groups.
    fn begin_light(&mut self, tracer: &Tracer, lights: &Lights, draws: &Draws) {
        self.rays.clear();
        let mut leaving = Vec::new();
        for group in lights.groups() {
            let [scrambles, _] = &draws.by_group[group as usize];
            for path in 0..draws.numbers.len() as u32 {
                let u = draws.spread(path, scrambles, ENDS);
                let Some(end) = lights.end(group, None, u) else {
                    continue;
                };
                let u = draws.spread(path, scrambles, LEAVING);
                if let Some((origin, direction)) = lights.leave(&end, u) {
                    self.rays.push(Ray {
                        origin,
                        direction,
                        t_max: f32::INFINITY,
                    });
                    leaving.push((path, end));
                }
            }
        }
        let draw = |z: &LightVertex| {
            let block = BLOCKS * z.number + ONWARD + z.end.group as u32;
            draws.block(z.path, block)
        };
        // a path's groups and vertices have numbers of their own
        let pass = |ray: u32, n: u32| {
            let (path, vertex) = (ray >> 2 & 0xfffff, ray >> 22);
            let block = PASS_LIGHT + ((vertex << 2 | ray & 3) * PASSES) + n;
            draws.block(path, block)[0]
        };
        self.trace_light((tracer, lights), &leaving, &draw, &pass);
    }

    /// Joins every vertex to the vertices of its light subpaths and, but for the first, to lights.
    fn join(&mut self, tracer: &Tracer, lights: &Lights, draws: &Draws) {
        let eyes = std::mem::take(&mut self.eyes);
        let mut from = 0;
        for x in &eyes {
            // both are sorted by path
            let ahead = self.light_vertices.get(from..).unwrap_or(&[]);
            from += ahead.partition_point(|z| z.path < x.path);
            let mut at = from;
            while let Some(z) = self.light_vertices.get(at).filter(|z| z.path == x.path) {
                let joint = connect(tracer, x, z);
                at += 1;
                self.push(x.path, joint);
            }
            if x.number > 0 {
                for group in lights.groups() {
                    let block = BLOCKS * x.number + CHOICE + group as u32;
                    let u = three(draws.block(x.path, block));
                    let end = lights.end(group, Some(x.site.position), u);
                    let joint = end.and_then(|end| next_event(tracer, lights, x, &end));
                    self.push(x.path, joint);
                }
            }
        }
        self.eyes = eyes;
    }

    /// Keeps a contribution until its shadow ray is traced.
    fn push(&mut self, path: u32, joint: Option<Joint>) {
        if let Some(joint) = joint {
            self.arriving.push((path, joint.value));
            self.shadows.push(Ray {
                origin: joint.origin,
                direction: joint.direction,
                t_max: joint.t_max,
            });
        }
    }

    /// Looks from every vertex at a point of a mirror that shows it a light.
    fn look_at_mirrors(&mut self, tracer: &Tracer, lights: &Lights, draws: &Draws) {
        self.looking.clear();
        self.looks.clear();
        for (i, x) in self.eyes.iter().enumerate() {
            for group in lights.groups() {
                let (end, place) = if x.number == 0 {
                    let [_, scrambles] = &draws.by_group[group as usize];
                    let end = draws.spread(x.path, scrambles, ENDS);
                    (end, draws.spread(x.path, scrambles, LEAVING))
                } else {
                    let block = BLOCKS * x.number + group as u32;
                    let end = draws.block(x.path, block + MIRRORED);
                    (three(end), three(draws.block(x.path, block + PLACE)))
                };
                let Some(end) = lights.end(group, None, end) else {
                    continue;
                };
                let from = x.site.position;
                let Some(to) = tracer.mirrors.propose_any(from, end.shown(), place) else {
                    continue;
                };
                if let Some(direction) = (to.position - from).try_normalize() {
                    self.looking.push((i, end, to.mirror));
                    self.looks.push(Ray {
                        origin: x.site.origin(direction),
                        direction,
                        t_max: f32::INFINITY,
                    });
                }
            }
        }
        rays::closest(&tracer.wide, &self.looks, &mut self.stack, &mut self.hits);
        std::mem::swap(&mut self.rays, &mut self.looks);
        let (looking, eyes) = (
            std::mem::take(&mut self.looking),
            std::mem::take(&mut self.eyes),
        );
        let factors = self.pass(tracer, &|k, n| {
            let x: &EyeVertex = &eyes[looking[k].0];
            let ray = 4 * x.number + looking[k].1.group as u32;
            draws.block(x.path, PASS_LOOKS + ray * PASSES + n)[0]
        });
        (self.looking, self.eyes) = (looking, eyes);
        std::mem::swap(&mut self.rays, &mut self.looks);
        let hits = std::mem::take(&mut self.hits);
        let looking = std::mem::take(&mut self.looking);
        for ((&(i, end, mirror), hit), factor) in looking.iter().zip(&hits).zip(factors) {
            if hit.triangle == INVALID || tracer.mirrors.of(hit.triangle) != mirror {
                continue;
            }
            let x = self.eyes[i];
            let place = (hit.triangle, hit.barycentrics);
            let Some(z) = LightVertex::first((tracer, lights), x.path, place, &end) else {
                continue;
            };
            let joint = connect(tracer, &x, &z).map(|joint| {
                // the way to the mirror is known to be free, the way from there to the light is not
                let origin = z.site.origin(z.toward);
                let (direction, t_max) = lights.shadow(&end, origin);
                Joint {
                    value: joint.value * factor,
                    origin,
                    direction,
                    t_max,
                }
            });
            self.push(x.path, joint);
        }
        self.hits = hits;
        self.looking = looking;
    }

    /// Adds what arrives along the shadow rays that nothing blocks.
    fn gather(&mut self, tracer: &Tracer) {
        rays::occluded(
            &tracer.wide,
            &self.shadows,
            &mut self.stack,
            &mut self.blocked,
        );
        for (k, &(path, value)) in self.arriving.iter().enumerate() {
            if !self.blocked[k] {
                self.sums[path as usize] += value;
            } else if tracer.passes {
                let (stack, hits) = (&mut self.stack, &mut self.beyond);
                let share = tracer.transmittance(&self.shadows[k], stack, hits);
                self.sums[path as usize] += value * share;
            }
        }
    }
}
