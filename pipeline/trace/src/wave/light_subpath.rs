//! Light subpaths: one ray from each path's point of light, and the vertex that it meets.

use super::part::Source;
use super::path::LightVertex;
use super::random;
use super::run::{Batch, Wave};
use crate::rays;
use crate::walk::Ray;
use glam::Vec3;
use rrf_materials::math::sin_cos_turn;
use rrf_materials::{INVALID, TILE};
use rrf_sampling::unit;

impl Wave {
    /// Sends one ray from each path's light, uniform over the sphere (density 1 / (4 pi) with
    /// respect to solid angle) or as the light's kind does, and keeps what it meets.
    pub(super) fn trace_light_subpaths(&mut self, batch: &Batch) {
        self.rays.clear();
        for first in (0..self.paths.len()).step_by(TILE) {
            let lanes = TILE.min(self.paths.len() - first);
            self.stratify(batch, random::LIGHT, first, lanes);
            for (i, path) in self.paths[first..first + lanes].iter().enumerate() {
                let light = &self.path_lights[path.slot as usize];
                let u = [self.draws.units[0][i], self.draws.units[1][i]];
                let direction = match batch.part.source {
                    Source::Set { set, .. } => {
                        let source = set.points.source(light.source);
                        source.and_then(|s| s.leave(u)).map(|l| l.direction)
                    }
                    _ => Some(uniform(u)),
                };
                self.rays.push(Ray {
                    origin: light.position,
                    direction: direction.unwrap_or(Vec3::Z),
                    // a light that sends nothing meets nothing
                    t_max: direction.map_or(0.0, |_| f32::INFINITY),
                });
            }
        }
        let tracer = batch.part.tracer;
        rays::closest(&tracer.wide, &self.rays, &mut self.stack, &mut self.hits);
        let mut factors = vec![Vec3::ONE; self.rays.len()];
        if tracer.lets_rays_pass() {
            self.pass_light_subpaths(batch, &mut factors);
        }
        self.light_vertices.clear();
        let rays = self.rays.iter().zip(&self.path_lights);
        for (((ray, light), hit), factor) in rays.zip(&self.hits).zip(factors) {
            self.light_vertices.push(if hit.triangle == INVALID {
                LightVertex::NONE
            } else {
                let toward = -ray.direction;
                let vertex = tracer.vertex(hit.triangle, hit.barycentrics, toward);
                let falloff = 1.0 / (hit.t * hit.t);
                let (intensity, solid_angle) = batch.part.source.intensity(light, ray.direction);
                LightVertex {
                    vertex,
                    toward,
                    falloff,
                    intensity: intensity * factor,
                    mirror: tracer.mirrors.flat_of(hit.triangle),
                    density: vertex.geometric.dot(toward) * falloff / solid_angle,
                }
            });
        }
    }
}

impl Wave {
    /// Lets the lights' rays pass panes and alpha masks; `factors` are those of their light.
    fn pass_light_subpaths(&mut self, batch: &Batch, factors: &mut [Vec3]) {
        let columns = self.paths.iter().zip(&self.rays).zip(factors);
        for (((path, ray), factor), hit) in columns.zip(&mut self.hits) {
            let row = &batch.rows[path.row as usize];
            let number = path.number + row.replicate * batch.replicate_paths as u32;
            let (stack, hits) = (&mut self.stack, &mut self.beyond);
            let stream = batch.part.stream;
            *factor = batch
                .part
                .tracer
                .pass_by_chance(ray, hit, stack, hits, |k| {
                    unit(stream.block(row.index, number, random::PASS_BLOCKS + k)[0])
                });
        }
    }
}

/// A direction uniform over the sphere.
#[inline]
fn uniform(u: [f32; 2]) -> Vec3 {
    let z = 1.0 - 2.0 * u[0];
    let radius = (1.0 - z * z).max(0.0).sqrt();
    let (sine, cosine) = sin_cos_turn(u[1]);
    Vec3::new(radius * cosine, radius * sine, z)
}
