//! Batches of rays as columns.
//!
//! Each batch is dispatched once to the widest instruction set that the processor has;
//! every one of them gives the same bits (no fused operations, no approximations).

use crate::wide::{Stack, Wide};
use glam::Vec3;
use multiversion::multiversion;

/// Rays `origin + t direction`, 0 < t < `t_max`: parallel columns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rays {
    /// Origins, world frame.
    pub origin: Vec<Vec3>,
    /// Directions, any length; distances are in units of it.
    pub direction: Vec<Vec3>,
    /// Where the ray ends.
    pub t_max: Vec<f32>,
}

/// The closest triangle of each ray: parallel columns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hits {
    /// Scene id of the triangle, or [`INVALID`] for a miss.
    pub triangle: Vec<u32>,
    /// Weights of the second and third corner.
    pub barycentrics: Vec<[f32; 2]>,
    /// Distance in units of the ray's direction; the ray's `t_max` for a miss.
    pub t: Vec<f32>,
}

impl Rays {
    /// Forgets all rays and keeps the memory.
    pub fn clear(&mut self) {
        self.origin.clear();
        self.direction.clear();
        self.t_max.clear();
    }

    /// Appends one ray.
    #[inline(always)]
    pub fn push(&mut self, origin: Vec3, direction: Vec3, t_max: f32) {
        self.origin.push(origin);
        self.direction.push(direction);
        self.t_max.push(t_max);
    }

    /// How many rays.
    pub fn len(&self) -> usize {
        self.origin.len()
    }

    /// Whether there is no ray.
    pub fn is_empty(&self) -> bool {
        self.origin.is_empty()
    }
}

impl Hits {
    /// Forgets all hits and keeps the memory.
    pub fn clear(&mut self) {
        self.triangle.clear();
        self.barycentrics.clear();
        self.t.clear();
    }
}

/// The closest triangle of every ray, into `hits`.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2"))]
pub(crate) fn closest(wide: &Wide, rays: &Rays, stack: &mut Stack, hits: &mut Hits) {
    hits.clear();
    let rows = rays.origin.iter().zip(&rays.direction).zip(&rays.t_max);
    for ((&origin, &direction), &t_max) in rows {
        let found = wide.closest(origin, direction, t_max, stack);
        hits.triangle.push(found.id);
        hits.barycentrics.push([found.b1, found.b2]);
        hits.t.push(found.t);
    }
}

/// Whether anything lies along each ray, into `blocked`.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2"))]
pub(crate) fn occluded(wide: &Wide, rays: &Rays, stack: &mut Stack, blocked: &mut Vec<bool>) {
    blocked.clear();
    let rows = rays.origin.iter().zip(&rays.direction).zip(&rays.t_max);
    blocked.extend(rows.map(|((&o, &d), &t)| wide.occluded(o, d, t, stack)));
}
