//! Batches of rays as columns.
//!
//! Each batch is dispatched once to the widest instruction set that the processor has;
//! every one of them gives the same bits (no fused operations, no approximations).

use crate::walk::{Found, Ray, Stack, Wide};
use glam::Vec3;
use multiversion::multiversion;
use std::cell::Cell;

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
    /// Scene id of the triangle, or [`rrf_scene::INVALID`] for a miss.
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

    pub(crate) fn rows(&self) -> impl Iterator<Item = Ray> {
        let columns = self.origin.iter().zip(&self.direction).zip(&self.t_max);
        columns.map(|((&origin, &direction), &t_max)| Ray {
            origin,
            direction,
            t_max,
        })
    }
}

/// The closest triangle of every ray, into `hits`.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2"))]
pub(crate) fn closest(wide: &Wide, rays: &[Ray], stack: &mut Stack, hits: &mut Vec<Found>) {
    hits.clear();
    wide.closest_of(rays, stack, hits);
}

/// Whether anything lies along each ray, into `blocked`.
#[multiversion(targets("x86_64+avx512f+avx512vl+avx512bw+avx512dq", "x86_64+avx2"))]
pub(crate) fn occluded(wide: &Wide, rays: &[Ray], stack: &mut Stack, blocked: &mut Vec<bool>) {
    blocked.clear();
    wide.occluded_of(rays, stack, blocked);
}

/// Rows that a batch of columns is turned into.
#[derive(Default)]
struct Scratch {
    rows: Vec<Ray>,
    found: Vec<Found>,
    stack: Stack,
}

thread_local! {
    /// Kept from batch to batch: a batch may be a few rays, and memory is dear where threads share it.
    static SCRATCH: Cell<Scratch> = Cell::default();
}

/// [`closest`] on columns.
pub(crate) fn closest_columns(wide: &Wide, rays: &Rays, hits: &mut Hits) {
    closest_columns_by(wide, rays, hits, |_, _, _| {});
}

/// [`closest`] on columns, each hit moved on by `onward`.
pub(crate) fn closest_columns_by(
    wide: &Wide,
    rays: &Rays,
    hits: &mut Hits,
    onward: impl Fn(&Ray, &mut Found, &mut Stack),
) {
    let mut scratch = SCRATCH.take();
    let Scratch { rows, found, stack } = &mut scratch;
    rows.clear();
    rows.extend(rays.rows());
    closest(wide, rows, stack, found);
    for (ray, found) in rows.iter().zip(found.iter_mut()) {
        onward(ray, found, stack);
    }
    hits.triangle.clear();
    hits.barycentrics.clear();
    hits.t.clear();
    hits.triangle.extend(found.iter().map(|f| f.triangle));
    hits.barycentrics
        .extend(found.iter().map(|f| f.barycentrics));
    hits.t.extend(found.iter().map(|f| f.t));
    SCRATCH.set(scratch);
}

/// [`occluded`] on columns.
pub(crate) fn occluded_columns(wide: &Wide, rays: &Rays, blocked: &mut Vec<bool>) {
    let mut scratch = SCRATCH.take();
    let Scratch { rows, stack, .. } = &mut scratch;
    rows.clear();
    rows.extend(rays.rows());
    occluded(wide, rows, stack, blocked);
    SCRATCH.set(scratch);
}
