//! Direct light by sampling the lights: the plain uniform estimator, and one that learns.
//!
//! A visible point knows how much of each group of lights could reach it ([`super::light_tree`]).
//! A first round of shadow rays goes out by that alone. It tells each block of 8 x 8 pixels which
//! groups are hidden (Donikian, Walter, Bala, Fernandez, Greenberg, *Accurate Direct
//! Illumination Using Iterative Adaptive Sampling*, IEEE TVCG 12(3), 2006), and how much the
//! rays of each pixel differ. The second round avoids hidden groups and, where a bound on the noise
//! is given, has as many rays as the bound needs, and counts alone.
//!
//! Unbiased: given what the first round found, the second one's mean is; both are added with
//! weights that are fixed before either. (A mean of all rays, whose number depends on the first
//! ones, would not be.)

use super::groups::{End, SampledLights};
use super::plan::{Rounds, SECOND, ShadowRays};
use super::rows::Rows;
use super::visibility::BlockVisibility;
use crate::timings::{FrameStage, Stopwatch};
use glam::Vec3;
use rrf_metrics::color::luminance;
use rrf_sampling::{Stage, Stream};
use rrf_trace::{Rays, Tracer};

/// Working columns, made once a thread.
#[derive(Clone, Debug, Default)]
pub struct SampledLighting {
    /// Radiance [W·sr⁻¹·m⁻²] of each visible point after [`SampledLighting::shade`].
    pub radiance: Vec<Vec3>,
    rays: Rays,
    blocked: Vec<bool>,
    arriving: Vec<ShadowRay>,
    learned: BlockVisibility,
    /// How much of each group could reach each row, row by row.
    reach: Vec<f32>,
    /// Sums of the round's values, row by row.
    sums: Vec<Vec3>,
    /// Rays of each row in the round at hand.
    counts: Vec<u32>,
    /// Cumulative probabilities of one row's groups.
    upto: Vec<f32>,
}

/// A shadow ray's row and group and, unless it is blocked, radiance over its probability.
#[derive(Clone, Copy, Debug)]
struct ShadowRay {
    row: u32,
    group: u32,
    value: Vec3,
    /// How much of all groups could reach the row.
    reach: f32,
}

/// The picture's part that is shaded: number of its first pixel, width of the picture.
pub(crate) type Pixels = (u64, u32);

/// Parameters that all rays of a tile share.
struct Aim<'a> {
    tracer: &'a Tracer<'a>,
    rows: Rows<'a>,
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
        self.plan_second(plan, rounds, rows, lights.groups());
        self.round(&aim, 1, watch);
        self.add(1.0 - rounds.first_weight);
    }

    /// One round's shadow rays, traced and summed.
    fn round(&mut self, aim: &Aim, number: u32, watch: &mut Stopwatch) {
        let seen = aim.rows.seen;
        let rows = seen.points.len();
        self.sums.clear();
        self.sums.resize(rows, Vec3::ZERO);
        self.rays.clear();
        self.arriving.clear();
        let mut before = (u32::MAX, 0);
        for row in 0..rows {
            let pixel = seen.pixel[row];
            before = (pixel, if pixel == before.0 { before.1 + 1 } else { 0 });
            self.aim_row(aim, row, number, before.1);
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

    /// One row's shadow rays; `sub` is its place among its pixel's.
    fn aim_row(&mut self, aim: &Aim, row: usize, number: u32, sub: u32) {
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
        for ray in 0..count {
            let [u, x, y, _] = aim.stream.units(index, number << 16 | ray, sub);
            let target = ((ray as f32 + u) / count as f32).min(1.0 - 0.5 * f32::EPSILON) * total;
            let chosen = if aim.plan.adaptive {
                self.group_at(target, total)
            } else {
                Some((target as u32, 1.0 / total, target.fract()))
            };
            let Some((group, probability, left)) = chosen else {
                continue;
            };
            let end = match aim.plan.adaptive {
                true => lights.end_in_group(seen, row, (group, left), [x, y]),
                false => lights
                    .end_of(seen, row, group, [left, x, y])
                    .map(|end| (end, 1.0)),
            };
            let Some((end, share)) = end else {
                continue;
            };
            self.send(aim, (row, group, total), end, probability * share);
        }
    }

    /// Queues the shadow ray to a light, if it could add something.
    fn send(
        &mut self,
        aim: &Aim,
        (row, group, reach): (usize, u32, f32),
        end: End,
        probability: f32,
    ) {
        let seen = aim.rows.seen;
        let (point, v) = (&seen.points[row], seen.viewers[row]);
        if point.normal.dot(end.toward) * point.normal.dot(v) <= 0.0 {
            return;
        }
        let all = || aim.lights.level_at(point.position, seen.side(row));
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

    /// Variances of single rays of the second round, by those of the first that arrived. Tells blocks what
    /// those of their rows would have that have found nothing themselves.
    fn expected_variances(&mut self, rows: Rows, groups: usize) -> Vec<f32> {
        let mut arriving = self.arriving.iter().zip(&self.blocked).peekable();
        let mut variances = Vec::with_capacity(self.counts.len());
        for (row, &count) in self.counts.iter().enumerate() {
            let reach = &self.reach[row * groups..(row + 1) * groups];
            let learned = &self.learned;
            let sum = |share: &dyn Fn(usize) -> f32| -> f32 {
                let groups = reach.iter().enumerate();
                groups.map(|(group, reach)| reach * share(group)).sum()
            };
            let first = sum(&|_| 1.0);
            let own = sum(&|group| learned.share(row, group));
            let block = sum(&|group| learned.block_share(row, group));
            let [mut own_squares, mut block_squares] = [0.0; 2];
            while let Some((ray, &blocked)) = arriving.next_if(|(ray, _)| ray.row as usize == row) {
                if !blocked {
                    // probabilities of the group in the first round over those in the second
                    let group = ray.group as usize;
                    let y = luminance(ray.value);
                    own_squares += y * y * own / (first * learned.share(row, group));
                    block_squares += y * y * block / (first * learned.block_share(row, group));
                }
            }
            let count = count.max(1) as f32;
            let mean = luminance(self.sums[row]) / count;
            let throughput = rows.throughput(row);
            let variance = |squares: f32| {
                let own = (squares - count * mean * mean) / (count - 1.0).max(1.0);
                own.max(0.0) * throughput * throughput
            };
            variances.push(variance(own_squares));
            self.learned.note_variance(row, variance(block_squares));
        }
        variances
    }

    /// Rays of each row in the second round, from the variance of the first.
    fn plan_second(&mut self, plan: ShadowRays, rounds: Rounds, rows: Rows, groups: usize) {
        let Some(noise) = plan.noise else {
            let counts = self.counts.iter_mut().enumerate();
            counts.for_each(|(row, count)| *count = rows.worth(row, rounds.second));
            return;
        };
        let variances = self.expected_variances(rows, groups);
        let allowances = rows.allowances();
        for (row, &own) in variances.iter().enumerate() {
            // a pixel's rays may have missed what its neighbours found
            let variance = own.max(self.learned.variance(row));
            let bound = noise * noise * allowances[row];
            let wanted = (variance / bound).ceil();
            let most = plan.count.saturating_sub(rounds.first).max(1);
            let least = rows.worth(row, SECOND.min(most));
            self.counts[row] = (wanted as u32).clamp(least, most);
        }
    }
}
