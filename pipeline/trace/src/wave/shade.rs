//! One bounce of all live paths: rows into tiles, kernels, and what they give into rays.

use super::kernels;
use super::load::load;
use super::path::Path;
use super::random;
use super::run::{Batch, Wave, looks};
use crate::light_set::LightSet;
use crate::mirrors::{NO_MIRROR, Shown};
use crate::walk::Ray;
use glam::Vec3;
use rrf_lights::EmittingTriangles;
use rrf_materials::TILE;
use rrf_sampling::roulette_tail;

impl Wave {
    /// Shades all live paths: fills the shadow rays and the next rays.
    pub(super) fn shade(&mut self, batch: &Batch, bounce: u32) {
        self.shadows.clear();
        self.arriving.clear();
        self.rays.clear();
        self.next.clear();
        for first in (0..self.paths.len()).step_by(TILE) {
            let lanes = TILE.min(self.paths.len() - first);
            let paths = self.paths[first..first + lanes].iter();
            let lights = &self.path_lights;
            load(
                batch,
                bounce,
                paths,
                lights,
                &mut self.vertices,
                &mut self.draws,
            );
            self.light(batch, bounce, first, lanes);
            if batch.looks_at_mirrors() {
                self.propose_connections(batch, bounce, first, lanes);
            }
            self.scatter(batch, bounce, first, lanes);
        }
    }

    /// Light that arrives at a tile.
    fn light(&mut self, batch: &Batch, bounce: u32, first: usize, lanes: usize) {
        let counts = bounce >= batch.first_lit();
        let source = batch.part.source;
        if counts && source.has_points() {
            let (at, out) = (&self.vertices, &mut self.contributions);
            kernels::next_event(at, source.connects(), &mut self.answers, out);
            self.queue_shadows(first, lanes, 1.0);
        }
        if source.connects() {
            self.load_light_vertices(batch, bounce, first, lanes);
            let (at, out) = (&self.vertices, &mut self.contributions);
            kernels::connect(at, &self.lit, &mut self.answers, out);
            self.queue_shadows(first, lanes, 1.0);
        }
        if counts && let Some((set, triangles)) = source.triangles() {
            self.load_lamps(batch, (set, triangles), bounce, first, lanes);
            let (at, out) = (&self.vertices, &mut self.contributions);
            kernels::next_lamp(at, &self.lamps, &mut self.answers, out);
            self.queue_shadows(first, lanes, 1.0);
        }
        if counts && source.has_far() {
            self.load_far(batch, bounce, first, lanes);
            let (at, out) = (&self.vertices, &mut self.contributions);
            kernels::next_far(at, &self.far, &mut self.answers, out);
            self.queue_shadows(first, lanes, f32::INFINITY);
        }
    }

    /// Copies the light vertices of a tile's paths into its columns.
    fn load_light_vertices(&mut self, batch: &Batch, bounce: u32, first: usize, lanes: usize) {
        let mirrors = &batch.part.tracer.mirrors;
        self.lit.surfaces.materials.clear();
        for (i, path) in self.paths[first..first + lanes].iter().enumerate() {
            let lit = &self.light_vertices[path.slot as usize];
            self.lit.surfaces.set(i, &lit.vertex);
            self.lit.toward.set(i, lit.toward);
            self.lit.falloff[i] = lit.falloff;
            self.lit.intensity.set(i, lit.intensity);
            self.lit.density[i] = lit.density;
            if lit.mirror != NO_MIRROR {
                let x = self.vertices.surfaces.position.get(i);
                let light = self.vertices.light.get(i);
                let y = lit.vertex.position;
                let light = Shown::point(light);
                self.lit.density[i] += looks(bounce) * mirrors.density(lit.mirror, x, light, y);
            }
        }
    }

    /// Chooses a point on a lamp for every path of a tile.
    fn load_lamps(
        &mut self,
        batch: &Batch,
        (set, triangles): (&LightSet, &EmittingTriangles),
        bounce: u32,
        first: usize,
        lanes: usize,
    ) {
        let tracer = batch.part.tracer;
        let block = random::LAMP_BLOCKS + bounce;
        random::independent(&mut self.draws, batch.part.stream, block);
        if bounce == batch.first_lit() {
            self.stratify(batch, random::LIGHT, first, lanes);
        }
        for i in 0..lanes {
            let u = [0, 1, 2].map(|d| self.draws.units[d][i]);
            let Some(at) = triangles.sample(u) else {
                self.lamps.radiance.set(i, Vec3::ZERO);
                continue;
            };
            let point = tracer.point(at.triangle, at.barycentrics);
            let toward = self.vertices.surfaces.position.get(i) - point.position;
            let front = point.normal.dot(toward) > 0.0;
            let normal = if front { point.normal } else { -point.normal };
            self.lamps.position.set(i, point.position);
            self.lamps.normal.set(i, normal);
            self.lamps.lift[i] = tracer.facets[at.triangle as usize].lift;
            let place = (at.triangle, at.barycentrics);
            let emitted = set.emission(tracer.scene, place, point.normal, toward);
            self.lamps.radiance.set(i, emitted);
            self.lamps.density[i] = triangles.density(at.triangle);
        }
    }

    /// Chooses light from afar for every path of a tile.
    fn load_far(&mut self, batch: &Batch, bounce: u32, first: usize, lanes: usize) {
        let block = random::FAR_BLOCKS + bounce;
        random::independent(&mut self.draws, batch.part.stream, block);
        if bounce == batch.first_lit() {
            self.stratify(batch, random::FAR, first, lanes);
        }
        for (i, path) in self.paths[first..first + lanes].iter().enumerate() {
            let u = [0, 1, 2].map(|d| self.draws.units[d][i]);
            let at = self.vertices.surfaces.position.get(i);
            let (source, openings) = (batch.part.source, batch.part.openings);
            let arrival = source.arrival_from_afar(batch.row(path), at, u, openings);
            let toward = arrival.map_or(Vec3::Z, |a| a.toward);
            self.far.toward.set(i, toward);
            (self.far.irradiance).set(i, arrival.map_or(Vec3::ZERO, |a| a.irradiance));
            self.far.density[i] = arrival.and_then(|a| a.density).unwrap_or(0.0);
        }
    }

    /// Draws three dimensions of the Sobol points of a tile's paths.
    pub(super) fn stratify(&mut self, batch: &Batch, dimension: usize, first: usize, lanes: usize) {
        for (i, path) in self.paths[first..first + lanes].iter().enumerate() {
            let point = batch.table.reversed(path.number as usize);
            let scrambles = &self.scrambles[path.row as usize];
            self.draws.stratify(i, point, scrambles, dimension);
        }
        random::stratified(&mut self.draws);
    }

    /// Keeps the contributions that are not zero; their shadow rays end at `t_max`.
    fn queue_shadows(&mut self, first: usize, lanes: usize, t_max: f32) {
        for (i, path) in self.paths[first..first + lanes].iter().enumerate() {
            let value = self.contributions.value.get(i);
            if value != Vec3::ZERO {
                self.arriving.push((path.slot, value));
                self.shadows.push(Ray {
                    origin: self.contributions.origin.get(i),
                    direction: self.contributions.direction.get(i),
                    t_max,
                });
            }
        }
    }

    /// Chooses where the paths of a tile go, and keeps those that go on.
    fn scatter(&mut self, batch: &Batch, bounce: u32, first: usize, lanes: usize) {
        random::independent(&mut self.draws, batch.part.stream, bounce);
        if (bounce as usize) < random::STRATIFIED {
            self.stratify(batch, 3 * bounce as usize, first, lanes);
        }
        let keep = if bounce == 0 {
            f32::INFINITY
        } else {
            batch.part.keep * roulette_tail(bounce)
        };
        let (at, answers) = (&self.vertices, &mut self.answers);
        kernels::scatter(at, &self.draws, keep, answers, &mut self.departures);
        for (i, before) in self.paths[first..first + lanes].iter().enumerate() {
            let density = self.departures.density[i];
            if density > 0.0 {
                let direction = self.departures.direction.get(i);
                let throughput = self.departures.throughput.get(i);
                let largest = throughput.max_element();
                let facet = &batch.part.tracer.facets[before.triangle as usize];
                let mut media = before.media;
                if facet.encloses && at.surfaces.geometric.get(i).dot(direction) < 0.0 {
                    media.cross(facet, facet.is_inside(before.viewer));
                }
                self.rays.push(Ray {
                    origin: self.departures.origin.get(i),
                    direction,
                    t_max: f32::INFINITY,
                });
                self.next.push(Path {
                    from: at.surfaces.position.get(i),
                    viewer: -direction,
                    throughput,
                    first: if bounce == 0 { largest } else { before.first },
                    density,
                    media,
                    ..*before
                });
            }
        }
    }
}
