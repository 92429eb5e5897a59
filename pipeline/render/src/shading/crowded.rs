//! Places whose surroundings are nearer than a patch is wide: in gaps and at contacts.
//!
//! A transfer takes the direct light on a patch as even. A point that sees a patch from less than the
//! patch's width away sees a part of it, whose light may be another. So answers there are not believed,
//! whatever the cell's error on rows, which read the same patches.

use super::job::{Job, PixelNames, Work};
use crate::follow::Lit;
use glam::Vec3;
use rrf_lights::about;
use rrf_materials::cosine_hemisphere;
use rrf_sampling::{Stage, Stream};
use rrf_scene::INVALID;

/// Rays that look for near surroundings of a point.
const PROBES: u32 = 8;
/// How many of them have to find some.
const FOUND: u32 = 2;

impl Job<'_> {
    /// Takes the trust from rows that lie in narrow places. Rays that were gathered tell by their length how
    /// near the surroundings of what they met are; from other rows probes are sent.
    pub(super) fn distrust_narrow(&self, work: &mut Work, names: PixelNames, depth: u32) {
        let Some(patches) = &self.patches else { return };
        let Work {
            seen,
            trust,
            probes,
            ..
        } = work;
        probes.rays.clear();
        probes.rows.clear();
        let stream = Stream::new(self.options.seed, Stage::Followed, u32::MAX - depth);
        for (row, trust) in trust.iter_mut().enumerate() {
            if !*trust || !self.answers_for(&seen.materials[row]) {
                continue;
            }
            let (point, side) = (&seen.points[row], seen.side(row));
            if let Some(carried) = seen.carried.get(row).filter(|c| c.lit != Lit::Whole) {
                *trust = carried.length >= patches.width(point);
                continue;
            }
            let index = names.first + u64::from(seen.pixel[row]);
            let shifts = stream.units(index, 0, 0);
            for ray in 0..PROBES {
                let u = [
                    (ray as f32 + shifts[0]) / PROBES as f32,
                    ((ray.reverse_bits() >> 8) as f32 / (1 << 24) as f32 + shifts[1]).fract(),
                ];
                let toward: Vec3 = about(side, cosine_hemisphere(u));
                let origin = self.tracer.lift(point.triangle, point.position, toward);
                probes.rays.push(origin, toward, patches.widest);
                probes.rows.push(row as u32);
            }
        }
        self.tracer.closest(&probes.rays, &mut probes.hits);
        let met = probes.hits.triangle.iter().zip(&probes.hits.barycentrics);
        let mut near: Vec<u32> = Vec::new();
        for ((&row, &t), (&triangle, &at)) in probes.rows.iter().zip(&probes.hits.t).zip(met) {
            if triangle != INVALID && t < patches.width(&self.tracer.point(triangle, at)) {
                near.push(row);
            }
        }
        for own in near.chunk_by(|a, b| a == b) {
            trust[own[0] as usize] = (own.len() as u32) < FOUND;
        }
    }
}
