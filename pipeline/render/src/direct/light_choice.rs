//! Choice of a light for each shadow ray, learned from the rays before it.

use crate::tile::VisiblePoints;
use glam::Vec3;
use rrf_metrics::color::luminance;

/// Side of a block in pixels.
const BLOCK: u32 = 8;
/// Least uniform share of the mixture.
const UNIFORM: f32 = 0.2;
/// Rays of a block for each light at which the uniform share is a half, if not least: what a
/// block has hardly looked at, it cannot know.
const HALF_LEARNED: f32 = 4.0;
/// Lit samples at which a pixel's own distribution gets half of what it can get.
const HALF_TRUST: f32 = 12.0;
/// Most of the share that is not uniform which a pixel's own distribution gets.
const MOST_TRUST: f32 = 0.5;

/// A shadow ray's row, light and, unless it is blocked, radiance over its probability.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShadowRay {
    pub(crate) row: u32,
    pub(crate) light: u32,
    pub(crate) value: Vec3,
}

/// Light found by the rays so far, and the distributions that follow from it.
#[derive(Clone, Debug, Default)]
pub(crate) struct LightChoice {
    pub(crate) lights: usize,
    /// Block of each row.
    block: Vec<u32>,
    /// Rows of each block.
    block_rows: Vec<u32>,
    /// Rays of each row in the rounds before.
    pub(crate) rays: u32,
    /// Sum of the luminances found from each light, block by block; then cumulative.
    found: Vec<f32>,
    cumulative: Vec<f32>,
    /// Each row's own findings: light and luminance, [`LightChoice::own_count`] of them.
    own: Vec<(u32, f32)>,
    own_count: Vec<u32>,
    /// Findings that a row can hold.
    room: usize,
}

/// Shares of the block's and the pixel's own distribution; the rest is uniform.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Mixture {
    block: f32,
    own: f32,
    own_total: f32,
}

impl LightChoice {
    /// Forgets everything; sorts the rows into blocks.
    pub(crate) fn begin(&mut self, seen: &VisiblePoints, lights: usize, rays: u32, width: u32) {
        let across = width.div_ceil(BLOCK);
        let blocks = seen.pixel.iter().map(|&pixel| {
            let (x, y) = (pixel % width, pixel / width);
            y / BLOCK * across + x / BLOCK
        });
        self.block.clear();
        self.block.extend(blocks);
        // numbered from 0 within the tile
        let mut names: Vec<u32> = self.block.clone();
        names.sort_unstable();
        names.dedup();
        for block in &mut self.block {
            *block = names.partition_point(|name| name < block) as u32;
        }
        let rows = seen.points.len();
        self.block_rows.clear();
        self.block_rows.resize(names.len(), 0);
        for &block in &self.block {
            self.block_rows[block as usize] += 1;
        }
        self.rays = 0;
        self.lights = lights;
        self.room = rays as usize;
        self.found.clear();
        self.found.resize(names.len() * lights, 0.0);
        self.cumulative.clear();
        self.cumulative.resize(names.len() * lights, 0.0);
        self.own.clear();
        self.own.resize(rows * self.room, (0, 0.0));
        self.own_count.clear();
        self.own_count.resize(rows, 0);
    }

    pub(crate) fn note(&mut self, arriving: &ShadowRay) {
        let (row, y) = (arriving.row as usize, luminance(arriving.value));
        let block = self.block[row] as usize;
        self.found[block * self.lights + arriving.light as usize] += y;
        let count = &mut self.own_count[row];
        if (*count as usize) < self.room {
            self.own[row * self.room + *count as usize] = (arriving.light, y);
            *count += 1;
        }
    }

    /// The blocks' cumulative distributions, up to a factor.
    pub(crate) fn accumulate(&mut self, rays: u32) {
        self.rays += rays;
        let lights = self.lights;
        let blocks = self
            .found
            .chunks(lights)
            .zip(self.cumulative.chunks_mut(lights));
        for (found, cumulative) in blocks {
            let mut sum = 0.0;
            for (y, upto) in found.iter().zip(cumulative) {
                sum += y;
                *upto = sum;
            }
        }
    }

    fn own(&self, row: usize) -> &[(u32, f32)] {
        &self.own[row * self.room..][..self.own_count[row] as usize]
    }

    fn of_block<'l>(&self, column: &'l [f32], row: usize) -> &'l [f32] {
        &column[self.block[row] as usize * self.lights..][..self.lights]
    }

    /// Weights of the distributions for a row.
    pub(crate) fn mixture(&self, row: usize, knows: bool) -> Mixture {
        let block = self.of_block(&self.cumulative, row);
        let total = block.last().copied().unwrap_or(0.0);
        if !knows || total.is_nan() || total <= 0.0 {
            return Mixture {
                block: 0.0,
                own: 0.0,
                own_total: 0.0,
            };
        }
        let own = self.own(row);
        let own_total: f32 = own.iter().map(|(_, y)| y).sum();
        let count = own.len() as f32;
        let looked = (self.rays * self.block_rows[self.block[row] as usize]) as f32;
        let looked = looked / self.lights as f32;
        let uniform = (HALF_LEARNED / (HALF_LEARNED + looked)).max(UNIFORM);
        let own = if own_total > 0.0 {
            (1.0 - uniform) * MOST_TRUST * count / (count + HALF_TRUST)
        } else {
            0.0
        };
        Mixture {
            block: 1.0 - uniform - own,
            own,
            own_total,
        }
    }

    /// A light by a number in [0, 1), and its probability under the whole mixture.
    pub(crate) fn choose(&self, row: usize, mixture: Mixture, u: f32) -> (u32, f32) {
        let last = self.lights.saturating_sub(1);
        let cumulative = self.of_block(&self.cumulative, row);
        let total = cumulative.last().copied().unwrap_or(0.0);
        let uniform = 1.0 - mixture.block - mixture.own;
        let light = if u < mixture.block {
            let target = u / mixture.block * total;
            cumulative.partition_point(|&upto| upto <= target)
        } else if u < mixture.block + mixture.own {
            let mut target = (u - mixture.block) / mixture.own * mixture.own_total;
            let chosen = self.own(row).iter().find(|(_, y)| {
                target -= y;
                target < 0.0
            });
            chosen
                .or(self.own(row).last())
                .map_or(0, |&(light, _)| light as usize)
        } else {
            ((u - mixture.block - mixture.own) / uniform * self.lights as f32) as usize
        };
        let light = light.min(last);
        let mut probability = uniform / self.lights as f32;
        if mixture.block > 0.0 {
            let found = self.of_block(&self.found, row);
            probability += mixture.block * found[light] / total;
        }
        if mixture.own > 0.0 {
            let own = self.own(row).iter().filter(|(l, _)| *l as usize == light);
            probability += mixture.own * own.map(|(_, y)| y).sum::<f32>() / mixture.own_total;
        }
        (light as u32, probability)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The chosen lights' frequencies are the probabilities that come with them.
    #[test]
    fn probabilities_are_those_of_the_choice() {
        let mut learned = LightChoice {
            lights: 5,
            block: vec![0],
            block_rows: vec![64],
            rays: 0,
            found: vec![3.0, 0.0, 1.0, 0.0, 4.0],
            cumulative: vec![0.0; 5],
            own: vec![(2, 1.0), (4, 0.5), (2, 0.5)],
            own_count: vec![3],
            room: 3,
        };
        learned.accumulate(4);
        let mixture = learned.mixture(0, true);
        assert!(mixture.block > 0.0 && mixture.own > 0.0);
        const STEPS: usize = 1 << 16;
        let (mut counts, mut told) = ([0; 5], [0.0; 5]);
        for step in 0..STEPS {
            let u = (step as f32 + 0.5) / STEPS as f32;
            let (light, probability) = learned.choose(0, mixture, u);
            counts[light as usize] += 1;
            told[light as usize] = probability;
        }
        assert!((told.iter().sum::<f32>() - 1.0).abs() < 1e-5);
        for (count, probability) in counts.iter().zip(told) {
            // an interval's steps, off by one at each end of its up to five pieces
            let expected = probability * STEPS as f32;
            assert!(
                (*count as f32 - expected).abs() <= 10.0,
                "{count} {expected}"
            );
        }
    }
}
