//! Direct light by sampling the lights: the plain uniform estimator, and one that learns.
//!
//! A visible point knows how much of each group of lights could reach it ([`super::light_tree`]).
//! A first round of shadow rays goes out by that alone. It tells each block of 8 x 8 pixels which
//! groups are hidden (Donikian, Walter, Bala, Fernandez, Greenberg, *Accurate Direct
//! Illumination Using Iterative Adaptive Sampling*, IEEE TVCG 12(3), 2006), and how much the
//! rays of each pixel differ. The last round avoids hidden groups and, where a bound on the noise
//! is given, has as many rays as the bound needs ([`super::planned`]), and counts alone.
//!
//! Unbiased: given what the other rounds found, the last one's mean is; both are added with
//! weights that are fixed before either. (A mean of all rays, whose number depends on the first
//! ones, would not be.)

use super::gain::SpreadGain;
use super::groups::{End, SampledLights};
use super::light_tree::Descent;
use super::numbers::{AmongRows, RayNumbers};
use super::plan::{LAST, Rounds, ShadowRays};
use super::rows::Rows;
use super::visibility::BlockVisibility;
use crate::timings::{FrameStage, Stopwatch};
use glam::Vec3;
use rrf_metrics::color::luminance;
use rrf_sampling::{Stage, Stream};
use rrf_trace::{Rays, Tracer};
use std::cell::OnceCell;

/// Working columns, made once a thread.
#[derive(Clone, Debug, Default)]
pub struct SampledLighting {
    /// Radiance [W·sr⁻¹·m⁻²] of each visible point after [`SampledLighting::shade`].
    pub radiance: Vec<Vec3>,
    rays: Rays,
    pub(super) blocked: Vec<bool>,
    pub(super) arriving: Vec<ShadowRay>,
    pub(super) learned: BlockVisibility,
    /// How much of each group could reach each row, row by row.
    pub(super) reach: Vec<f32>,
    /// Sums of the round's values, row by row.
    pub(super) sums: Vec<Vec3>,
    /// Rays of each row in the round at hand.
    pub(super) counts: Vec<u32>,
    /// Cumulative probabilities of one row's groups.
    upto: Vec<f32>,
    /// The way of one row's last ray down the light tree.
    descent: Descent,
    pub(super) gain: SpreadGain,
}

/// A shadow ray's row and group and, unless it is blocked, radiance over its probability.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShadowRay {
    pub(super) row: u32,
    pub(super) group: u32,
    pub(super) value: Vec3,
    /// How much of all groups could reach the row.
    reach: f32,
}

/// The picture's part that is shaded: number of its first pixel, width of the picture.
pub(crate) type Pixels = (u64, u32);

/// Parameters that all rays of a tile share.
pub(super) struct Aim<'a> {
    tracer: &'a Tracer<'a>,
    pub(super) rows: Rows<'a>,
    lights: &'a SampledLights<'a>,
    plan: ShadowRays,
    stream: Stream,
    /// Number of the first pixel.
    first: u64,
}

impl SampledLighting {
    /// Estimates the light that each visible point sends to its viewer straight from `lights`, less
    /// that of lamps which its own rays bring. Random numbers belong to pixels.
    pub fn shade(
        &mut self,
        tracer: &Tracer,
        rows: Rows,
        lights: &SampledLights,
        (plan, seed): (ShadowRays, u64),
        (first, width): Pixels,
        watch: &mut Stopwatch,
    ) {
        let (seen, count) = (rows.seen, rows.seen.points.len());
        self.radiance.clear();
        self.radiance.resize(count, Vec3::ZERO);
        if lights.is_empty() || plan.count == 0 {
            return;
        }
        let aim = Aim {
            tracer,
            rows,
            lights,
            plan,
            stream: Stream::new(seed, Stage::Direct, rows.depth),
            first,
        };
        self.counts.clear();
        let Some(rounds) = Rounds::of(plan) else {
            self.counts
                .extend((0..count).map(|row| rows.worth(row, plan.count)));
            self.round(&aim, 0, watch);
            self.add(1.0);
            return;
        };
        self.reach.clear();
        for row in 0..count {
            lights.reach(seen, row, &rows.asking(row), &mut self.reach);
        }
        self.learned.begin(seen, lights.groups(), width);
        self.counts
            .extend((0..count).map(|row| rows.worth(row, rounds.first)));
        self.round(&aim, 0, watch);
        self.add(rounds.first_weight);
        match plan.noise {
            None => {
                let counts = self.counts.iter_mut().enumerate();
                counts.for_each(|(row, count)| *count = rows.worth(row, rounds.second));
            }
            Some(noise) => {
                self.plan_last(&aim, noise, rounds.second.max(1), watch);
            }
        }
        self.round(&aim, LAST, watch);
        self.add(1.0 - rounds.first_weight);
    }

    /// One round's shadow rays, traced and summed.
    pub(super) fn round(&mut self, aim: &Aim, number: u32, watch: &mut Stopwatch) {
        let seen = aim.rows.seen;
        let rows = seen.points.len();
        self.sums.clear();
        self.sums.resize(rows, Vec3::ZERO);
        self.rays.clear();
        self.arriving.clear();
        let mut first = 0;
        for pixel in seen.pixel.chunk_by(|a, b| a == b) {
            let mut among = AmongRows {
                rows: pixel.len() as u32,
                ..AmongRows::default()
            };
            for row in first..first + pixel.len() {
                self.aim_row(aim, row, number, among);
                among.row += 1;
                among.rays += self.counts[row];
            }
            first += pixel.len();
        }
        watch.end(FrameStage::Direct);
        aim.tracer.occluded(&self.rays, &mut self.blocked);
        watch.end(FrameStage::ShadowRays);
        for (arriving, &blocked) in self.arriving.iter().zip(&self.blocked) {
            let row = arriving.row as usize;
            let y = if blocked {
                0.0
            } else {
                luminance(arriving.value)
            };
            if !blocked {
                self.sums[row] += arriving.value;
            }
            if aim.plan.adaptive && number == 0 {
                // its chance is its group's reach over all groups'
                let brought = y / arriving.reach;
                self.learned.note(row, arriving.group as usize, brought);
            }
        }
        watch.end(FrameStage::Direct);
    }

    /// One row's shadow rays.
    fn aim_row(&mut self, aim: &Aim, row: usize, number: u32, among: AmongRows) {
        let (seen, lights) = (aim.rows.seen, aim.lights);
        let index = aim.first + u64::from(seen.pixel[row]);
        let total = if aim.plan.adaptive {
            self.accumulate(lights.groups(), row, number > 0)
        } else {
            lights.count() as f32
        };
        if total.is_nan() || total <= 0.0 {
            return;
        }
        let count = self.counts[row];
        let numbers = RayNumbers::new((&aim.stream, index), number, among, count);
        self.descent.clear();
        let level = OnceCell::new();
        for ray in 0..count {
            let [u, x, y] = match aim.plan.adaptive {
                true => numbers.of(ray),
                false => {
                    let [u, x, y, _] = aim.stream.units(index, ray, among.row);
                    let step = (ray as f32 + u) / count as f32;
                    [step.min(1.0 - 0.5 * f32::EPSILON), x, y]
                }
            };
            let target = u * total;
            let chosen = if aim.plan.adaptive {
                self.group_at(target, total)
            } else {
                Some((target as u32, 1.0 / total, target.fract()))
            };
            let Some((group, probability, left)) = chosen else {
                continue;
            };
            let end = match aim.plan.adaptive {
                true => {
                    let descent = &mut self.descent;
                    lights.end_in_group(seen, row, (group, left), [x, y], descent)
                }
                false => lights
                    .end_of(seen, row, group, [left, x, y])
                    .map(|end| (end, 1.0)),
            };
            let Some((end, share)) = end else {
                continue;
            };
            self.send(aim, (row, group, total), end, probability * share, &level);
        }
    }

    /// Queues the shadow ray to a light, if it could add something.
    fn send(
        &mut self,
        aim: &Aim,
        (row, group, reach): (usize, u32, f32),
        end: End,
        probability: f32,
        level: &OnceCell<f32>,
    ) {
        let seen = aim.rows.seen;
        let (point, v) = (&seen.points[row], seen.viewers[row]);
        if point.normal.dot(end.toward) * point.normal.dot(v) <= 0.0 {
            return;
        }
        let all = || *level.get_or_init(|| aim.lights.level_at(point.position, seen.side(row)));
        let value = aim.rows.value(row, &end, &all);
        let value = end.irradiance * value / probability;
        if value == Vec3::ZERO {
            return;
        }
        self.arriving.push(ShadowRay {
            row: row as u32,
            group,
            value,
            reach,
        });
        let origin = aim.tracer.lift(point.triangle, point.position, v);
        match end.place {
            Some(place) => self.rays.push(origin, place - origin, 1.0),
            None => self.rays.push(origin, end.toward, f32::INFINITY),
        }
    }

    /// Cumulative weights of a row's groups; gives their sum.
    fn accumulate(&mut self, groups: usize, row: usize, knows: bool) -> f32 {
        self.upto.clear();
        let mut sum = 0.0;
        let reach = &self.reach[row * groups..(row + 1) * groups];
        for (group, reach) in reach.iter().enumerate() {
            let share = if knows {
                self.learned.share(row, group)
            } else {
                1.0
            };
            sum += reach * share;
            self.upto.push(sum);
        }
        sum
    }

    /// The group at a place of the cumulative weights: number, probability, place within it.
    fn group_at(&self, target: f32, total: f32) -> Option<(u32, f32, f32)> {
        let last = self
            .upto
            .iter()
            .rposition(|&upto| upto < total)
            .map_or(0, |k| k + 1);
        let group = self.upto.partition_point(|&upto| upto <= target).min(last);
        let before = group.checked_sub(1).map_or(0.0, |k| self.upto[k]);
        let weight = self.upto[group] - before;
        (weight > 0.0).then(|| {
            let left = ((target - before) / weight).clamp(0.0, 1.0 - 0.5 * f32::EPSILON);
            (group as u32, weight / total, left)
        })
    }

    /// Adds the round's means, times a weight.
    fn add(&mut self, weight: f32) {
        let sums = self.sums.iter().zip(&self.counts);
        for (radiance, (sum, &count)) in self.radiance.iter_mut().zip(sums) {
            if count > 0 {
                *radiance += weight / count as f32 * *sum;
            }
        }
    }
}
