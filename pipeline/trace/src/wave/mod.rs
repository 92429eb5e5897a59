//! Many paths at once, one bounce after another.
//!
//! Live paths are rows; a bounce takes them sixty-four at a time through the shading kernels,
//! collects the shadow rays and the next rays of all of them, and traces each collection as one
//! batch. Rows keep their order, so sums are folded in the order of the paths.

mod kernels;
mod random;
mod tile;

use crate::rays::{self, Hits, Rays};
use crate::rng::Stream;
use crate::sobol::{DIMENSIONS, Scramble, Table};
use crate::surface::{SurfacePoint, Vertex};
use crate::tracer::Tracer;
use crate::wide::Stack;
use glam::Vec3;
use kernels::{Departures, Lit, Vertices};
use random::Draws;
use rrf_scene::INVALID;
use std::f32::consts::PI;
use tile::{Contributions, TILE};

/// How a path's survival follows its throughput: below 1 / KEEP of the first one it may end.
const KEEP: f32 = 1.5;

/// Where paths start.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row {
    pub(crate) point: SurfacePoint,
    /// Unit direction to the viewer.
    pub(crate) viewer: Vec3,
    /// Position of the point light of 1 W/sr.
    pub(crate) light: Vec3,
    /// Index of the sample in its stream.
    pub(crate) index: u64,
    /// Which independent part of the sample this is.
    pub(crate) replicate: u32,
}

/// One live path.
#[derive(Clone, Copy)]
struct Path {
    /// Row times paths a row plus path.
    slot: u32,
    triangle: u32,
    barycentrics: [f32; 2],
    viewer: Vec3,
    throughput: Vec3,
    first: f32,
    density: f32,
}

/// What a point light's ray met.
#[derive(Clone, Copy)]
struct LightVertex {
    vertex: Vertex,
    toward: Vec3,
    falloff: f32,
    density: f32,
}

/// Working memory of one thread.
pub(crate) struct Wave {
    paths: Vec<Path>,
    next: Vec<Path>,
    rays: Rays,
    shadows: Rays,
    shadow_values: Vec<(u32, Vec3)>,
    hits: Hits,
    blocked: Vec<bool>,
    light_vertices: Vec<LightVertex>,
    scrambles: Vec<[Scramble; DIMENSIONS]>,
    /// Estimate of each path, by slot.
    pub(crate) sums: Vec<Vec3>,
    stack: Stack,
    vertices: Box<Vertices>,
    lit: Box<Lit>,
    draws: Box<Draws>,
    contributions: Box<Contributions>,
    departures: Box<Departures>,
}

/// What every path of a batch shares.
#[derive(Clone, Copy)]
pub(crate) struct Batch<'a> {
    pub(crate) tracer: &'a Tracer<'a>,
    pub(crate) rows: &'a [Row],
    /// Paths a row in this batch, and in the whole replicate; the first one's number in it.
    pub(crate) paths: usize,
    pub(crate) replicate_paths: usize,
    pub(crate) first_path: usize,
    pub(crate) stream: Stream,
    pub(crate) table: &'a Table,
}

impl Batch<'_> {
    #[inline(always)]
    fn row(&self, slot: u32) -> (usize, &Row) {
        let row = slot as usize / self.paths;
        (row, &self.rows[row])
    }

    /// Number of a slot's path in its replicate.
    #[inline(always)]
    fn path(&self, slot: u32) -> usize {
        self.first_path + slot as usize % self.paths
    }
}

impl Wave {
    pub(crate) fn new(tracer: &Tracer) -> Wave {
        Wave {
            paths: Vec::new(),
            next: Vec::new(),
            rays: Rays::default(),
            shadows: Rays::default(),
            shadow_values: Vec::new(),
            hits: Hits::default(),
            blocked: Vec::new(),
            light_vertices: Vec::new(),
            scrambles: Vec::new(),
            sums: Vec::new(),
            stack: tracer.wide.stack(),
            vertices: Box::new(Vertices::ZERO),
            lit: Box::new(Lit::ZERO),
            draws: Box::new(Draws::ZERO),
            contributions: Box::new(Contributions::ZERO),
            departures: Box::new(Departures::ZERO),
        }
    }

    /// Estimates indirect light at every row: `sums[row * paths + path]`.
    pub(crate) fn run(&mut self, batch: &Batch) {
        let slots = batch.rows.len() * batch.paths;
        self.sums.clear();
        self.sums.resize(slots, Vec3::ZERO);
        self.scrambles.clear();
        self.scrambles.extend(
            batch
                .rows
                .iter()
                .map(|r| random::scrambles(batch.stream, r.index, r.replicate)),
        );
        self.shine(batch, slots);
        self.start(batch, slots);
        for bounce in 0.. {
            self.shade(batch, bounce);
            self.gather_light(batch.tracer);
            self.travel(batch.tracer);
            if self.paths.is_empty() {
                break;
            }
        }
    }

    /// One path a slot, at the row's point.
    fn start(&mut self, batch: &Batch, slots: usize) {
        self.paths.clear();
        self.paths.extend((0..slots as u32).map(|slot| {
            let (_, row) = batch.row(slot);
            Path {
                slot,
                triangle: row.point.triangle,
                barycentrics: row.point.barycentrics,
                viewer: row.viewer,
                throughput: Vec3::ONE,
                first: 0.0,
                density: 0.0,
            }
        }));
    }

    /// Sends one ray from each slot's light, uniform over the sphere: density 1 / (4 pi).
    fn shine(&mut self, batch: &Batch, slots: usize) {
        self.rays.clear();
        for first in (0..slots).step_by(TILE) {
            let lanes = TILE.min(slots - first);
            for i in 0..lanes {
                let slot = (first + i) as u32;
                let (row, _) = batch.row(slot);
                let point = batch.table.reversed(batch.path(slot));
                self.draws
                    .stratify(i, point, &self.scrambles[row], random::LIGHT);
            }
            random::stratified(&mut self.draws);
            for i in 0..lanes {
                let (_, row) = batch.row((first + i) as u32);
                let z = 1.0 - 2.0 * self.draws.units[0][i];
                let radius = (1.0 - z * z).max(0.0).sqrt();
                let (sine, cosine) = crate::math::sin_cos_turn(self.draws.units[1][i]);
                let direction = Vec3::new(radius * cosine, radius * sine, z);
                self.rays.push(row.light, direction, f32::INFINITY);
            }
        }
        rays::closest(
            &batch.tracer.wide,
            &self.rays,
            &mut self.stack,
            &mut self.hits,
        );
        self.light_vertices.clear();
        for slot in 0..slots {
            let toward = -self.rays.direction[slot];
            let (triangle, t) = (self.hits.triangle[slot], self.hits.t[slot]);
            let vertex = if triangle == INVALID || t <= 0.0 {
                LightVertex {
                    vertex: Vertex::NONE,
                    toward,
                    falloff: 0.0,
                    density: 0.0,
                }
            } else {
                let vertex = batch
                    .tracer
                    .vertex(triangle, self.hits.barycentrics[slot], toward);
                let falloff = 1.0 / (t * t);
                LightVertex {
                    vertex,
                    toward,
                    falloff,
                    density: vertex.geometric.dot(toward) * falloff / (4.0 * PI),
                }
            };
            self.light_vertices.push(vertex);
        }
    }

    /// Shades all live paths: fills the shadow rays and the next rays.
    fn shade(&mut self, batch: &Batch, bounce: u32) {
        self.shadows.clear();
        self.shadow_values.clear();
        self.rays.clear();
        self.next.clear();
        for first in (0..self.paths.len()).step_by(TILE) {
            let lanes = TILE.min(self.paths.len() - first);
            self.load(batch, bounce, first, lanes);
            let mixed = batch.tracer.mixed;
            if bounce > 0 {
                kernels::next_event(mixed, &self.vertices, &mut self.contributions);
                self.queue_shadows(first, lanes);
            }
            kernels::connect(mixed, &self.vertices, &self.lit, &mut self.contributions);
            self.queue_shadows(first, lanes);
            random::independent(&mut self.draws, batch.stream, bounce);
            if (bounce as usize) < random::STRATIFIED {
                random::stratified(&mut self.draws);
            }
            let keep = if bounce == 0 { f32::INFINITY } else { KEEP };
            kernels::scatter(
                mixed,
                &self.vertices,
                &self.draws,
                keep,
                &mut self.departures,
            );
            self.queue_departures(bounce, first, lanes);
        }
    }

    /// Copies the rows of a tile into its columns.
    fn load(&mut self, batch: &Batch, bounce: u32, first: usize, lanes: usize) {
        for i in 0..lanes {
            let path = &self.paths[first + i];
            let (row_index, row) = batch.row(path.slot);
            let number = batch.path(path.slot);
            let vertex = batch
                .tracer
                .vertex(path.triangle, path.barycentrics, path.viewer);
            self.vertices.surfaces.set(i, &vertex);
            self.vertices.viewer.set(i, path.viewer);
            self.vertices.throughput.set(i, path.throughput);
            self.vertices.first[i] = path.first;
            self.vertices.density[i] = path.density;
            self.vertices.light.set(i, row.light);
            let lit = &self.light_vertices[path.slot as usize];
            self.lit.surfaces.set(i, &lit.vertex);
            self.lit.toward.set(i, lit.toward);
            self.lit.falloff[i] = lit.falloff;
            self.lit.density[i] = lit.density;
            let whole = row.replicate as usize * batch.replicate_paths + number;
            self.draws.name(i, row.index, whole as u32);
            if (bounce as usize) < random::STRATIFIED {
                let point = batch.table.reversed(number);
                let scrambles = &self.scrambles[row_index];
                self.draws
                    .stratify(i, point, scrambles, 3 * bounce as usize);
            }
        }
    }

    /// Keeps the contributions that are not zero.
    fn queue_shadows(&mut self, first: usize, lanes: usize) {
        for i in 0..lanes {
            let value = self.contributions.value.get(i);
            if value != Vec3::ZERO {
                self.shadow_values.push((self.paths[first + i].slot, value));
                let origin = self.contributions.origin.get(i);
                self.shadows
                    .push(origin, self.contributions.direction.get(i), 1.0);
            }
        }
    }

    /// Keeps the paths that go on.
    fn queue_departures(&mut self, bounce: u32, first: usize, lanes: usize) {
        for i in 0..lanes {
            let density = self.departures.density[i];
            if density > 0.0 {
                let direction = self.departures.direction.get(i);
                let throughput = self.departures.throughput.get(i);
                let before = &self.paths[first + i];
                self.rays
                    .push(self.departures.origin.get(i), direction, f32::INFINITY);
                self.next.push(Path {
                    viewer: -direction,
                    throughput,
                    first: if bounce == 0 {
                        throughput.max_element()
                    } else {
                        before.first
                    },
                    density,
                    ..*before
                });
            }
        }
    }

    /// Adds the contributions that nothing blocks.
    fn gather_light(&mut self, tracer: &Tracer) {
        rays::occluded(
            &tracer.wide,
            &self.shadows,
            &mut self.stack,
            &mut self.blocked,
        );
        for (&(slot, value), &blocked) in self.shadow_values.iter().zip(&self.blocked) {
            if !blocked {
                self.sums[slot as usize] += value;
            }
        }
    }

    /// Moves the paths that go on to what their rays meet; those that leave the scene end.
    fn travel(&mut self, tracer: &Tracer) {
        rays::closest(&tracer.wide, &self.rays, &mut self.stack, &mut self.hits);
        self.paths.clear();
        for (i, path) in self.next.iter().enumerate() {
            let (triangle, t) = (self.hits.triangle[i], self.hits.t[i]);
            if triangle != INVALID {
                let normal = Vec3::from(tracer.normals[triangle as usize]);
                self.paths.push(Path {
                    triangle,
                    barycentrics: self.hits.barycentrics[i],
                    density: path.density * normal.dot(path.viewer).abs() / (t * t),
                    ..*path
                });
            }
        }
    }
}
