//! Light that flat glossy surfaces show the paths' vertices (see [`crate::mirrors`]).

use super::kernels;
use super::load::load;
use super::path::Connection;
use super::random;
use super::run::{Batch, Wave, looks};
use crate::mirrors::Shown;
use crate::rays;
use crate::walk::Ray;
use glam::Vec3;
use rrf_materials::math::pick;
use rrf_materials::{INVALID, TILE};
use rrf_sampling::unit;

impl Wave {
    /// Sends a ray to a point of a mirror from every vertex of a tile that sees the light in one.
    pub(super) fn propose_connections(
        &mut self,
        batch: &Batch,
        bounce: u32,
        first: usize,
        lanes: usize,
    ) {
        let mirrors = &batch.part.tracer.mirrors;
        let block = random::SPECULAR_BLOCKS + bounce;
        random::independent(&mut self.draws, batch.part.stream, block);
        if bounce == 0 {
            self.stratify(batch, random::SPECULAR, first, lanes);
        }
        let looking = looks(bounce);
        for (i, path) in self.paths[first..first + lanes].iter().enumerate() {
            let mut u = [0, 1, 2].map(|d| self.draws.units[d][i]);
            if u[0] >= looking {
                continue;
            }
            u[0] /= looking;
            let x = self.vertices.surfaces.position.get(i);
            let light = Shown::point(self.vertices.light.get(i));
            let Some(to) = mirrors.propose(x, light, u) else {
                continue;
            };
            let direction = to.position - x;
            if self.vertices.surfaces.geometric.get(i).dot(direction) <= 0.0 {
                continue;
            }
            self.connections.push(Connection {
                path: *path,
                mirror: to.mirror,
                share: to.share * looking,
            });
            self.connection_rays.push(Ray {
                origin: self.vertices.surfaces.origin(i),
                direction: direction.normalize(),
                t_max: f32::INFINITY,
            });
        }
    }

    /// Follows those rays; where they meet the mirror, queues what comes from the light that way.
    pub(super) fn follow_connections(&mut self, batch: &Batch, bounce: u32) {
        let tracer = batch.part.tracer;
        rays::closest(
            &tracer.wide,
            &self.connection_rays,
            &mut self.stack,
            &mut self.hits,
        );
        if tracer.lets_rays_pass() {
            self.pass_connections(batch, bounce);
        }
        let mut met = std::mem::take(&mut self.met);
        met.clear();
        for (connection, hit) in self.connections.iter().zip(&self.hits) {
            if hit.triangle != INVALID && tracer.mirrors.flat_of(hit.triangle) == connection.mirror
            {
                met.push((*connection, *hit));
            }
        }
        for tile in met.chunks(TILE) {
            let paths = tile.iter().map(|(connection, _)| &connection.path);
            let lights = &self.path_lights;
            load(
                batch,
                bounce,
                paths,
                lights,
                &mut self.vertices,
                &mut self.draws,
            );
            self.lit.surfaces.materials.clear();
            for (i, (connection, hit)) in tile.iter().enumerate() {
                self.load_specular(batch, i, connection, hit.triangle, hit.barycentrics);
            }
            let (at, out) = (&self.vertices, &mut self.contributions);
            kernels::connect(at, &self.lit, &mut self.answers, out);
            for (i, (Connection { path, .. }, _)) in tile.iter().enumerate() {
                let value = self.contributions.value.get(i);
                if value != Vec3::ZERO {
                    let origin = self.lit.surfaces.origin(i);
                    self.arriving.push((path.slot, value));
                    self.shadows.push(Ray {
                        origin,
                        direction: self.path_lights[path.slot as usize].position - origin,
                        t_max: 1.0,
                    });
                }
            }
        }
        self.met = met;
        self.connections.clear();
        self.connection_rays.clear();
    }

    /// Lets rays to mirrors pass panes and alpha masks.
    fn pass_connections(&mut self, batch: &Batch, bounce: u32) {
        let first = random::PASS_BLOCKS + (1 << 25) + bounce * random::PASSES;
        let columns = self.connections.iter_mut().zip(&self.connection_rays);
        for ((connection, ray), hit) in columns.zip(&mut self.hits) {
            let path = &mut connection.path;
            let row = &batch.rows[path.row as usize];
            let number = path.number + row.replicate * batch.replicate_paths as u32;
            let (stack, hits) = (&mut self.stack, &mut self.beyond);
            let stream = batch.part.stream;
            path.throughput *= batch
                .part
                .tracer
                .pass_by_chance(ray, hit, stack, hits, |k| {
                    unit(stream.block(row.index, number, first + k)[0])
                });
        }
    }

    /// Lane `i` of the lit points: a point of a mirror, seen from the light.
    fn load_specular(
        &mut self,
        batch: &Batch,
        i: usize,
        connection: &Connection,
        triangle: u32,
        at: [f32; 2],
    ) {
        let tracer = batch.part.tracer;
        let own = &self.path_lights[connection.path.slot as usize];
        let light = own.position;
        let position = tracer.facets[triangle as usize].position(at);
        let to = light - position;
        let distance2 = to.length_squared();
        let toward = pick(distance2 > 0.0, to / distance2.sqrt(), Vec3::Z);
        let vertex = tracer.vertex(triangle, at, toward);
        let falloff = if distance2 > 0.0 {
            1.0 / distance2
        } else {
            0.0
        };
        let (intensity, solid_angle) = batch.part.source.intensity(own, -toward);
        let by_light = vertex.geometric.dot(toward) * falloff / solid_angle;
        let x = self.vertices.surfaces.position.get(i);
        let Connection { mirror, share, .. } = *connection;
        let by_mirror =
            (tracer.mirrors).density_in(mirror, share, x, Shown::point(light), vertex.position);
        self.lit.surfaces.set(i, &vertex);
        self.lit.toward.set(i, toward);
        self.lit.falloff[i] = falloff;
        self.lit.intensity.set(i, intensity);
        self.lit.density[i] = by_light + by_mirror;
    }
}
