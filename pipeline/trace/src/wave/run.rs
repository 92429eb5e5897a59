//! One thread's paths.

use super::kernels::{self, Departures, LampLanes, Lit, Vertices};
use super::path::{LightVertex, Path};
use super::random::{self, Draws};
use super::tile::{Contributions, TILE};
use super::{Part, Row, Source};
use crate::lamps;
use crate::math::sin_cos_turn;
use crate::rays::{self, Hits, Rays};
use crate::sobol::{DIMENSIONS, Scramble, Table};
use crate::tracer::Tracer;
use crate::wide::Stack;
use glam::Vec3;
use rrf_scene::INVALID;
use std::f32::consts::PI;

/// How a path's survival follows its throughput: below 1 / KEEP of the first one it may end.
const KEEP: f32 = 1.5;

/// Rows whose paths travel together.
#[derive(Clone, Copy)]
pub(super) struct Batch<'a> {
    pub(super) part: Part<'a>,
    pub(super) rows: &'a [Row],
    /// Paths a row in this batch, and in the whole replicate; the first one's number in it.
    pub(super) paths: usize,
    pub(super) replicate_paths: usize,
    pub(super) first_path: usize,
    pub(super) table: &'a Table,
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

    /// The first bounce whose light counts.
    fn first_lit(&self) -> u32 {
        u32::from(!self.part.direct)
    }
}

/// Working memory of one thread.
pub(super) struct Wave {
    paths: Vec<Path>,
    next: Vec<Path>,
    rays: Rays,
    hits: Hits,
    shadows: Rays,
    shadow_values: Vec<(u32, Vec3)>,
    blocked: Vec<bool>,
    light_vertices: Vec<LightVertex>,
    scrambles: Vec<[Scramble; DIMENSIONS]>,
    /// Estimate of each path, by slot.
    sums: Vec<Vec3>,
    stack: Stack,
    vertices: Box<Vertices>,
    lit: Box<Lit>,
    lamps: Box<LampLanes>,
    draws: Box<Draws>,
    contributions: Box<Contributions>,
    departures: Box<Departures>,
}

impl Wave {
    pub(super) fn new(tracer: &Tracer) -> Wave {
        Wave {
            paths: Vec::new(),
            next: Vec::new(),
            rays: Rays::default(),
            hits: Hits::default(),
            shadows: Rays::default(),
            shadow_values: Vec::new(),
            blocked: Vec::new(),
            light_vertices: Vec::new(),
            scrambles: Vec::new(),
            sums: Vec::new(),
            stack: tracer.wide.stack(),
            vertices: Box::new(Vertices::ZERO),
            lit: Box::new(Lit::ZERO),
            lamps: Box::new(LampLanes::ZERO),
            draws: Box::new(Draws::ZERO),
            contributions: Box::new(Contributions::ZERO),
            departures: Box::new(Departures::ZERO),
        }
    }

    /// Traces every row's paths; gives the estimate of each, shape [rows, paths].
    pub(super) fn run(&mut self, batch: &Batch) -> &[Vec3] {
        let slots = batch.rows.len() * batch.paths;
        self.sums.clear();
        self.sums.resize(slots, Vec3::ZERO);
        let stream = batch.part.stream;
        self.scrambles.clear();
        self.scrambles.extend(
            batch
                .rows
                .iter()
                .map(|row| random::scrambles(stream, row.index, row.replicate)),
        );
        if batch.part.source == (Source::Point { connect: true }) {
            self.shine(batch, slots);
        }
        self.start(batch, slots);
        for bounce in 0.. {
            self.shade(batch, bounce);
            self.gather_light(batch);
            self.travel(batch, bounce);
            if self.paths.is_empty() || batch.part.direct {
                break;
            }
        }
        &self.sums
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
                first: 1.0,
                density: 0.0,
            }
        }));
    }

    /// Sends one ray from each slot's light, uniform over the sphere, and keeps what it meets.
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
                let (sine, cosine) = sin_cos_turn(self.draws.units[1][i]);
                let direction = Vec3::new(radius * cosine, radius * sine, z);
                self.rays.push(row.light, direction, f32::INFINITY);
            }
        }
        let tracer = batch.part.tracer;
        rays::closest(&tracer.wide, &self.rays, &mut self.stack, &mut self.hits);
        self.light_vertices.clear();
        for (slot, direction) in self.rays.direction.iter().enumerate() {
            let (triangle, t) = (self.hits.triangle[slot], self.hits.t[slot]);
            self.light_vertices.push(if triangle == INVALID {
                LightVertex::NONE
            } else {
                let toward = -*direction;
                let vertex = tracer.vertex(triangle, self.hits.barycentrics[slot], toward);
                let falloff = 1.0 / (t * t);
                LightVertex {
                    vertex,
                    toward,
                    falloff,
                    density: vertex.geometric.dot(toward) * falloff / (4.0 * PI),
                }
            });
        }
    }

    /// Shades all live paths: fills the shadow rays and the next rays.
    fn shade(&mut self, batch: &Batch, bounce: u32) {
        self.shadows.clear();
        self.shadow_values.clear();
        self.rays.clear();
        self.next.clear();
        let (mixed, stream) = (batch.part.tracer.mixed, batch.part.stream);
        for first in (0..self.paths.len()).step_by(TILE) {
            let lanes = TILE.min(self.paths.len() - first);
            self.load(batch, bounce, first, lanes);
            match batch.part.source {
                Source::Point { connect } => {
                    if bounce >= batch.first_lit() {
                        let (at, out) = (&self.vertices, &mut self.contributions);
                        kernels::next_event(mixed, at, connect, out);
                        self.queue_shadows(first, lanes);
                    }
                    if connect {
                        self.load_light_vertices(first, lanes);
                        let (at, out) = (&self.vertices, &mut self.contributions);
                        kernels::connect(mixed, at, &self.lit, out);
                        self.queue_shadows(first, lanes);
                    }
                }
                Source::Lamps if bounce >= batch.first_lit() => {
                    self.load_lamps(batch, bounce, first, lanes);
                    let (at, out) = (&self.vertices, &mut self.contributions);
                    kernels::next_lamp(mixed, at, &self.lamps, out);
                    self.queue_shadows(first, lanes);
                }
                Source::Lamps => {}
            }
            random::independent(&mut self.draws, stream, bounce);
            if (bounce as usize) < random::STRATIFIED {
                self.stratify(batch, 3 * bounce as usize, first, lanes);
            }
            let keep = if bounce == 0 { f32::INFINITY } else { KEEP };
            let (at, out) = (&self.vertices, &mut self.departures);
            kernels::scatter(mixed, at, &self.draws, keep, out);
            self.queue_departures(bounce, first, lanes);
        }
    }

    /// Copies the rows of a tile into its columns.
    fn load(&mut self, batch: &Batch, bounce: u32, first: usize, lanes: usize) {
        let tracer = batch.part.tracer;
        for (i, path) in self.paths[first..first + lanes].iter().enumerate() {
            let (_, row) = batch.row(path.slot);
            let vertex = tracer.vertex(path.triangle, path.barycentrics, path.viewer);
            self.vertices.surfaces.set(i, &vertex);
            self.vertices.viewer.set(i, path.viewer);
            self.vertices.throughput.set(i, path.throughput);
            self.vertices.first[i] = path.first;
            self.vertices.density[i] = path.density;
            self.vertices.light.set(i, row.light);
            let number = row.replicate as usize * batch.replicate_paths + batch.path(path.slot);
            self.draws.name(i, row.index, number as u32);
        }
        debug_assert!(bounce == 0 || self.vertices.density[..lanes].iter().all(|&d| d >= 0.0));
    }

    /// Copies the light vertices of a tile's paths into its columns.
    fn load_light_vertices(&mut self, first: usize, lanes: usize) {
        for (i, path) in self.paths[first..first + lanes].iter().enumerate() {
            let lit = &self.light_vertices[path.slot as usize];
            self.lit.surfaces.set(i, &lit.vertex);
            self.lit.toward.set(i, lit.toward);
            self.lit.falloff[i] = lit.falloff;
            self.lit.density[i] = lit.density;
        }
    }

    /// Chooses a point on a lamp for every path of a tile.
    fn load_lamps(&mut self, batch: &Batch, bounce: u32, first: usize, lanes: usize) {
        let tracer = batch.part.tracer;
        random::independent(
            &mut self.draws,
            batch.part.stream,
            random::LAMP_BLOCKS + bounce,
        );
        if bounce == batch.first_lit() {
            self.stratify(batch, random::LIGHT, first, lanes);
        }
        for i in 0..lanes {
            let u = [0, 1, 2].map(|d| self.draws.units[d][i]);
            let Some(at) = tracer.lamps.sample(u) else {
                self.lamps.radiance.set(i, Vec3::ZERO);
                continue;
            };
            let point = tracer.point(at.triangle, at.barycentrics);
            let toward = self.vertices.surfaces.position.get(i) - point.position;
            let front = point.normal.dot(toward) > 0.0;
            self.lamps.position.set(i, point.position);
            self.lamps
                .normal
                .set(i, if front { point.normal } else { -point.normal });
            self.lamps.lift[i] = tracer.lifts[at.triangle as usize];
            self.lamps.radiance.set(i, tracer.emission(&point, toward));
            self.lamps.density[i] = tracer.lamps.density(at.triangle);
        }
    }

    /// Draws three dimensions of the tile's Sobol points.
    fn stratify(&mut self, batch: &Batch, dimension: usize, first: usize, lanes: usize) {
        for (i, path) in self.paths[first..first + lanes].iter().enumerate() {
            let (row, _) = batch.row(path.slot);
            let point = batch.table.reversed(batch.path(path.slot));
            self.draws
                .stratify(i, point, &self.scrambles[row], dimension);
        }
        random::stratified(&mut self.draws);
    }

    /// Keeps the contributions that are not zero.
    fn queue_shadows(&mut self, first: usize, lanes: usize) {
        for (i, path) in self.paths[first..first + lanes].iter().enumerate() {
            let value = self.contributions.value.get(i);
            if value != Vec3::ZERO {
                self.shadow_values.push((path.slot, value));
                let origin = self.contributions.origin.get(i);
                self.shadows
                    .push(origin, self.contributions.direction.get(i), 1.0);
            }
        }
    }

    /// Keeps the paths that go on.
    fn queue_departures(&mut self, bounce: u32, first: usize, lanes: usize) {
        for (i, before) in self.paths[first..first + lanes].iter().enumerate() {
            let density = self.departures.density[i];
            if density > 0.0 {
                let direction = self.departures.direction.get(i);
                let throughput = self.departures.throughput.get(i);
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
    fn gather_light(&mut self, batch: &Batch) {
        let wide = &batch.part.tracer.wide;
        rays::occluded(wide, &self.shadows, &mut self.stack, &mut self.blocked);
        for (&(slot, value), &blocked) in self.shadow_values.iter().zip(&self.blocked) {
            if !blocked {
                self.sums[slot as usize] += value;
            }
        }
    }

    /// Moves the paths that go on to what their rays meet, and adds what a lamp met there
    /// emits; paths that leave the scene end.
    fn travel(&mut self, batch: &Batch, bounce: u32) {
        let tracer = batch.part.tracer;
        rays::closest(&tracer.wide, &self.rays, &mut self.stack, &mut self.hits);
        let lamps = batch.part.source == Source::Lamps && bounce >= batch.first_lit();
        self.paths.clear();
        for (i, path) in self.next.iter().enumerate() {
            let (triangle, t) = (self.hits.triangle[i], self.hits.t[i]);
            if triangle == INVALID {
                continue;
            }
            let normal = Vec3::from(tracer.normals[triangle as usize]);
            let density = path.density * normal.dot(path.viewer).abs() / (t * t);
            let other = tracer.lamps.density(triangle);
            if lamps && other > 0.0 {
                // The balance heuristic against the lamp's point having been chosen.
                let emitted = lamps::emission(tracer.scene, triangle, normal, path.viewer);
                let weight = density / (density + other);
                self.sums[path.slot as usize] += path.throughput * emitted * weight;
            }
            self.paths.push(Path {
                triangle,
                barycentrics: self.hits.barycentrics[i],
                density,
                ..*path
            });
        }
    }
}
