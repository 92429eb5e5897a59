//! Light subpaths: one ray from each path's point light, and the vertex that it meets.

use super::path::LightVertex;
use super::random;
use super::run::{Batch, Wave};
use crate::rays;
use crate::walk::Ray;
use glam::Vec3;
use rrf_materials::math::sin_cos_turn;
use rrf_materials::{INVALID, TILE};
use std::f32::consts::PI;

impl Wave {
    /// Sends one ray from each path's light, uniform over the sphere (density 1 / (4 pi) with
    /// respect to solid angle), and keeps what it meets.
    pub(super) fn trace_light_subpaths(&mut self, batch: &Batch) {
        self.rays.clear();
        for first in (0..self.paths.len()).step_by(TILE) {
            let lanes = TILE.min(self.paths.len() - first);
            self.stratify(batch, random::LIGHT, first, lanes);
            for (i, path) in self.paths[first..first + lanes].iter().enumerate() {
                let z = 1.0 - 2.0 * self.draws.units[0][i];
                let radius = (1.0 - z * z).max(0.0).sqrt();
                let (sine, cosine) = sin_cos_turn(self.draws.units[1][i]);
                self.rays.push(Ray {
                    origin: batch.row(path).light,
                    direction: Vec3::new(radius * cosine, radius * sine, z),
                    t_max: f32::INFINITY,
                });
            }
        }
        let tracer = batch.part.tracer;
        rays::closest(&tracer.wide, &self.rays, &mut self.stack, &mut self.hits);
        self.light_vertices.clear();
        for (ray, hit) in self.rays.iter().zip(&self.hits) {
            self.light_vertices.push(if hit.triangle == INVALID {
                LightVertex::NONE
            } else {
                let toward = -ray.direction;
                let vertex = tracer.vertex(hit.triangle, hit.barycentrics, toward);
                let falloff = 1.0 / (hit.t * hit.t);
                LightVertex {
                    vertex,
                    toward,
                    falloff,
                    mirror: tracer.mirrors.of(hit.triangle),
                    density: vertex.geometric.dot(toward) * falloff / (4.0 * PI),
                }
            });
        }
    }
}
