//! One thread's paths.

use super::kernels::Answers;
use super::lanes::{Departures, FarLanes, LampLanes, Lit, Vertices};
use super::part::{Part, Row};
use super::path::{Connection, LightVertex, Path, PathLight};
use super::random::{self, Draws};
use super::tile::Contributions;
use crate::media::Media;
use crate::mirrors::{NO_MIRROR, Shown};
use crate::rays;
use crate::tracer::Tracer;
use crate::walk::{Found, Ray, Stack};
use glam::Vec3;
use rrf_sampling::sobol::{self, DIMENSIONS, Scramble, Table};
use rrf_sampling::unit;
use rrf_scene::INVALID;

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

/// Of the vertices after the first, this many look at mirrors: half of them cost a tenth more
/// variance and a fifth less time (docs/science/report.md).
const LATER: f32 = 0.5;

/// The largest number that a choice takes.
const BELOW_ONE: f32 = 1.0 - 0.5 * f32::EPSILON;

/// The share of a bounce's vertices that look at mirrors.
pub(super) fn looks(bounce: u32) -> f32 {
    if bounce == 0 { 1.0 } else { LATER }
}

impl Batch<'_> {
    #[inline(always)]
    pub(super) fn row(&self, path: &Path) -> &Row {
        &self.rows[path.row as usize]
    }

    /// The first bounce whose light counts.
    pub(super) fn first_lit(&self) -> u32 {
        u32::from(!self.part.direct)
    }

    /// Density with which a mirror would have led a path to where its ray ended.
    fn mirror_density(&self, path: &Path, light: Vec3, hit: &Found, bounce: u32) -> f32 {
        let tracer = self.part.tracer;
        let mirror = tracer.mirrors.flat_of(hit.triangle);
        if mirror == NO_MIRROR {
            return 0.0;
        }
        let y = tracer.facets[hit.triangle as usize].position(hit.barycentrics);
        looks(bounce)
            * tracer
                .mirrors
                .density(mirror, path.from, Shown::point(light), y)
    }

    /// Whether light that mirrors show is sought.
    pub(super) fn looks_at_mirrors(&self) -> bool {
        self.part.source.connects() && !self.part.tracer.mirrors.is_empty()
    }
}

/// Working memory of one thread.
pub(super) struct Wave {
    /// Live paths at their vertices, and those that have just left theirs.
    pub(super) paths: Vec<Path>,
    pub(super) next: Vec<Path>,
    /// Rays of `next`, and what they meet.
    pub(super) rays: Vec<Ray>,
    pub(super) hits: Vec<Found>,
    /// Shadow rays, and what arrives along each: the path's slot and the radiance.
    pub(super) shadows: Vec<Ray>,
    pub(super) arriving: Vec<(u32, Vec3)>,
    blocked: Vec<bool>,
    /// Hits of one ray beyond a surface that it passes.
    pub(super) beyond: Vec<Found>,
    /// Vertices that look at mirrors, their rays, and which of them met one.
    pub(super) connections: Vec<Connection>,
    pub(super) connection_rays: Vec<Ray>,
    pub(super) met: Vec<(Connection, Found)>,
    /// One a slot, if the source has points, and the points that they see if it is connected to.
    pub(super) path_lights: Vec<PathLight>,
    pub(super) light_vertices: Vec<LightVertex>,
    /// One a row.
    pub(super) scrambles: Vec<[Scramble; DIMENSIONS]>,
    /// Estimate of each path, by slot.
    sums: Vec<Vec3>,
    pub(super) stack: Stack,
    pub(super) vertices: Box<Vertices>,
    pub(super) lit: Box<Lit>,
    pub(super) lamps: Box<LampLanes>,
    pub(super) far: Box<FarLanes>,
    pub(super) draws: Box<Draws>,
    pub(super) contributions: Box<Contributions>,
    pub(super) departures: Box<Departures>,
    pub(super) answers: Box<Answers>,
}

impl Wave {
    pub(super) fn new(tracer: &Tracer) -> Wave {
        Wave {
            paths: Vec::new(),
            next: Vec::new(),
            rays: Vec::new(),
            hits: Vec::new(),
            shadows: Vec::new(),
            arriving: Vec::new(),
            blocked: Vec::new(),
            beyond: Vec::new(),
            connections: Vec::new(),
            connection_rays: Vec::new(),
            met: Vec::new(),
            path_lights: Vec::new(),
            light_vertices: Vec::new(),
            scrambles: Vec::new(),
            sums: Vec::new(),
            stack: tracer.wide.stack(),
            vertices: Box::new(Vertices::ZERO),
            lit: Box::new(Lit::ZERO),
            lamps: Box::new(LampLanes::ZERO),
            far: Box::new(FarLanes::ZERO),
            draws: Box::new(Draws::ZERO),
            contributions: Box::new(Contributions::ZERO),
            departures: Box::new(Departures::ZERO),
            answers: Box::new(Answers::ZERO),
        }
    }

    /// Traces every row's paths; gives the estimate of each, shape [rows, paths].
    pub(super) fn run(&mut self, batch: &Batch) -> &[Vec3] {
        self.start(batch);
        if batch.part.source.has_points() {
            self.choose_points(batch);
        }
        if batch.part.source.connects() {
            self.trace_light_subpaths(batch);
        }
        for bounce in 0.. {
            self.shade(batch, bounce);
            if batch.looks_at_mirrors() {
                self.follow_connections(batch, bounce);
            }
            self.gather_light(batch);
            self.travel(batch, bounce);
            let ends = self.paths.is_empty() || batch.part.direct;
            if ends || batch.part.tracer.is_halted() {
                break;
            }
        }
        &self.sums
    }

    /// All paths at their rows' points.
    fn start(&mut self, batch: &Batch) {
        self.sums.clear();
        self.sums.resize(batch.rows.len() * batch.paths, Vec3::ZERO);
        self.scrambles.clear();
        self.paths.clear();
        self.path_lights.clear();
        for (index, row) in batch.rows.iter().enumerate() {
            let stream = batch.part.stream;
            self.scrambles
                .push(sobol::scrambles(stream, row.index, row.replicate));
            let first = index * batch.paths;
            self.paths.extend((0..batch.paths).map(|path| Path {
                row: index as u32,
                number: (batch.first_path + path) as u32,
                slot: (first + path) as u32,
                triangle: row.point.triangle,
                barycentrics: row.point.barycentrics,
                viewer: row.viewer,
                throughput: Vec3::ONE,
                first: 1.0,
                density: 0.0,
                media: Media::NONE,
                from: Vec3::ZERO,
                mirror_density: 0.0,
            }));
        }
    }

    /// A point of light for each path.
    fn choose_points(&mut self, batch: &Batch) {
        let (source, count) = (batch.part.source, batch.replicate_paths as f32);
        for path in &self.paths {
            let row = batch.row(path);
            let point = source.point(row, || {
                let number = path.number + row.replicate * batch.replicate_paths as u32;
                let words = batch
                    .part
                    .stream
                    .block(row.index, number, random::POINT_BLOCK);
                // a replicate's paths share the lights by power, as evenly as they can
                ((path.number as f32 + unit(words[0])) / count).min(BELOW_ONE)
            });
            self.path_lights.push(point);
        }
    }

    /// Adds what arrives along the shadow rays that nothing blocks.
    fn gather_light(&mut self, batch: &Batch) {
        let tracer = batch.part.tracer;
        rays::occluded(
            &tracer.wide,
            &self.shadows,
            &mut self.stack,
            &mut self.blocked,
        );
        let passes = tracer.lets_rays_pass();
        for (k, &(slot, value)) in self.arriving.iter().enumerate() {
            if !self.blocked[k] {
                self.sums[slot as usize] += value;
            } else if passes {
                let (stack, hits) = (&mut self.stack, &mut self.beyond);
                let share = tracer.transmittance(&self.shadows[k], stack, hits);
                self.sums[slot as usize] += value * share;
            }
        }
    }

    /// Lets the next rays pass panes and alpha masks, and absorbs what glass does up to where they end.
    fn pass(&mut self, batch: &Batch, bounce: u32) {
        let tracer = batch.part.tracer;
        let first = random::PASS_BLOCKS + (2 + bounce) * random::PASSES;
        let paths = self.next.iter_mut().zip(&self.rays);
        for ((path, ray), hit) in paths.zip(&mut self.hits) {
            if tracer.lets_rays_pass() {
                let row = &batch.rows[path.row as usize];
                let number = path.number + row.replicate * batch.replicate_paths as u32;
                let (stack, hits) = (&mut self.stack, &mut self.beyond);
                let factor = tracer.pass_by_chance(ray, hit, stack, hits, |k| {
                    let stream = batch.part.stream;
                    unit(stream.block(row.index, number, first + k)[0])
                });
                path.throughput *= factor;
            }
            if hit.triangle != INVALID {
                let facet = &tracer.facets[hit.triangle as usize];
                // rays start off their surface
                let distance = hit.t + ray.origin.distance(path.from);
                path.throughput *= tracer.left_after(distance, path.media, facet, path.viewer);
            }
        }
    }

    /// Moves the paths that go on to what their rays meet, and adds what a lamp met there
    /// emits; paths that leave the scene end with the light from there.
    fn travel(&mut self, batch: &Batch, bounce: u32) {
        let tracer = batch.part.tracer;
        rays::closest(&tracer.wide, &self.rays, &mut self.stack, &mut self.hits);
        if tracer.encloses || tracer.passes {
            self.pass(batch, bounce);
        }
        let (source, lit) = (batch.part.source, bounce >= batch.first_lit());
        let lamps = source.triangles().filter(|_| lit);
        let far = source.has_far() && lit;
        let mirrors = batch.looks_at_mirrors();
        self.paths.clear();
        for (path, hit) in self.next.iter().zip(&self.hits) {
            if hit.triangle == INVALID {
                if far {
                    let toward = -path.viewer;
                    let (row, openings) = (batch.row(path), batch.part.openings);
                    let met = source.met(row, path.from, toward, path.density, openings);
                    self.sums[path.slot as usize] += path.throughput * met;
                }
                continue;
            }
            let normal = tracer.facets[hit.triangle as usize].normal;
            let density = path.density * normal.dot(path.viewer).abs() / (hit.t * hit.t);
            if let Some((set, triangles)) = lamps
                && triangles.density(hit.triangle) > 0.0
            {
                // The balance heuristic against the lamp's point having been chosen.
                let at = (hit.triangle, hit.barycentrics);
                let emitted = set.emission(tracer.scene, at, normal, path.viewer);
                let weight = density / (density + triangles.density(hit.triangle));
                self.sums[path.slot as usize] += path.throughput * emitted * weight;
            }
            self.paths.push(Path {
                triangle: hit.triangle,
                barycentrics: hit.barycentrics,
                density,
                mirror_density: match mirrors {
                    true => {
                        let light = self.path_lights[path.slot as usize].position;
                        batch.mirror_density(path, light, hit, bounce)
                    }
                    false => 0.0,
                },
                ..*path
            });
        }
    }
}
