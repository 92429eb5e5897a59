//! Number of rays of the last round, where a bound on the noise decides.
//!
//! The rays of the first round say how much single ones will differ. Trial rays from a quarter of the pixels
//! say how much less the means of many differ than those of independent rays would ([`super::gain`]).

use super::gain;
use super::plan::{SECOND, TRIALS};
use super::rows::Rows;
use super::sampled::{Aim, SampledLighting};
use crate::timings::Stopwatch;
use rrf_metrics::color::luminance;

/// Share of the planned rays in each trial round, and the least number.
const TRIAL: f32 = 0.125;
const LEAST_TRIAL: u32 = 4;
/// Share of the bound on the standard error that numbers of rays aim at: they follow from estimates, and too few
/// rays add more to the mean square than too many take off.
const MARGIN: f32 = 0.9;

/// Variance of a row's single rays, and what that of their mean may be.
#[derive(Clone, Copy, Debug)]
struct Planned {
    variance: f32,
    bound: f32,
}

impl Planned {
    /// Independent rays that it takes.
    fn rays(self) -> f32 {
        self.variance / self.bound
    }
}

impl SampledLighting {
    /// Variances of single rays of the last round, by those of the first that arrived. Tells blocks what
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
                    // probabilities of the group in the first round over those in the last
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

    /// Variance of single rays of each row in the rounds to come, and the bound on that of their mean.
    fn planned(&mut self, rows: Rows, groups: usize, noise: f32) -> Vec<Planned> {
        let variances = self.expected_variances(rows, groups);
        let allowances = rows.allowances().into_iter().zip(variances).enumerate();
        let planned = allowances.map(|(row, (allowance, own))| Planned {
            // a pixel's rays may have missed what its neighbours found
            variance: own.max(self.learned.variance(row)),
            bound: MARGIN * MARGIN * noise * noise * allowance,
        });
        planned.collect()
    }

    /// Two rounds of a share of the rays from a share of the pixels. They tell blocks how much faster than
    /// those of independent rays the errors fall, and count for nothing else.
    fn try_out(&mut self, aim: &Aim, planned: &[Planned], most: u32, watch: &mut Stopwatch) {
        let (rows, pixels) = (aim.rows, &aim.rows.seen.pixel);
        self.gain.begin(self.learned.blocks());
        let trial = |row: usize| match self.learned.is_trial(row) {
            true => {
                let rays = TRIAL * planned[row].rays();
                (rays as u32).clamp(LEAST_TRIAL.min(most), most)
            }
            false => 0,
        };
        self.counts.clear();
        self.counts.extend((0..planned.len()).map(trial));
        self.round(aim, TRIALS[0], watch);
        let sums = self.sums.clone();
        self.round(aim, TRIALS[1], watch);
        let mut first = 0;
        for pixel in pixels.chunk_by(|a, b| a == b) {
            let (mut difference, mut independent, mut rays) = (0.0, 0.0, 0);
            for row in first..first + pixel.len() {
                let count = self.counts[row];
                if count > 0 {
                    let means =
                        [sums[row], self.sums[row]].map(|sum| luminance(sum) / count as f32);
                    difference += rows.throughput(row) * (means[0] - means[1]);
                    independent += 2.0 * planned[row].variance / count as f32;
                    rays += count;
                }
            }
            if rays > 0 {
                let rays = rays as f32 / pixel.len() as f32;
                let block = self.learned.block(first);
                self.gain.note(block, difference, independent, rays);
            }
            first += pixel.len();
        }
    }

    /// Rays of each row in the last round.
    pub(super) fn plan_last(&mut self, aim: &Aim, noise: f32, most: u32, watch: &mut Stopwatch) {
        let planned = self.planned(aim.rows, self.learned.groups(), noise);
        self.try_out(aim, &planned, most, watch);
        for (row, planned) in planned.iter().enumerate() {
            let exponent = self.gain.exponent(self.learned.block(row));
            let wanted = gain::rays(planned.rays(), exponent);
            let least = aim.rows.worth(row, SECOND.min(most));
            self.counts[row] = (wanted as u32).clamp(least, most);
        }
    }
}
