//! How much of each group of lights the first rays of blocks of pixels have found, and how much those
//! rays differ.

use crate::tile::VisiblePoints;

/// Side of a block in pixels.
const BLOCK: u32 = 8;
/// The least that a group counts which a block has not seen: light that is missed so far is still
/// found, and no ray weighs more than four times what it would without learning.
const LEAST_SEEN: f32 = 0.25;

/// How much of each group the rays of a block have found.
#[derive(Clone, Debug, Default)]
pub(crate) struct BlockVisibility {
    groups: usize,
    /// Block of each row.
    block: Vec<u32>,
    /// Whether trial rays go out from each row.
    trial: Vec<bool>,
    /// Rays of each block to each group, and the sum of squares of what they brought, over what could
    /// have been.
    looked: Vec<u32>,
    brought: Vec<f32>,
    /// Rays of each block that brought something, and the sum of squares of all.
    arrived: Vec<u32>,
    squares: Vec<f32>,
    /// Groups that rays of each row itself have reached, row by row.
    found: Vec<bool>,
    /// Rows of each block, and the sum of their variances.
    rows: Vec<u32>,
    variance: Vec<f64>,
}

impl BlockVisibility {
    /// Forgets everything; sorts the rows into blocks.
    pub(crate) fn begin(&mut self, seen: &VisiblePoints, groups: usize, width: u32) {
        let across = width.div_ceil(BLOCK);
        let blocks = seen.pixel.iter().map(|&pixel| {
            let (x, y) = (pixel % width, pixel / width);
            y / BLOCK * across + x / BLOCK
        });
        self.block.clear();
        self.block.extend(blocks);
        let trial = seen.pixel.iter().map(|&pixel| {
            let (x, y) = (pixel % width, pixel / width);
            // one of four in every row, staggered
            (x + 2 * y).is_multiple_of(4)
        });
        self.trial.clear();
        self.trial.extend(trial);
        // numbered from 0 within the tile
        let mut names: Vec<u32> = self.block.clone();
        names.sort_unstable();
        names.dedup();
        for block in &mut self.block {
            *block = names.partition_point(|name| name < block) as u32;
        }
        self.groups = groups;
        self.looked.clear();
        self.looked.resize(names.len() * groups, 0);
        self.brought.clear();
        self.brought.resize(names.len() * groups, 0.0);
        self.arrived.clear();
        self.arrived.resize(names.len(), 0);
        self.squares.clear();
        self.squares.resize(names.len(), 0.0);
        self.found.clear();
        self.found.resize(self.block.len() * groups, false);
        self.rows.clear();
        self.rows.resize(names.len(), 0);
        self.variance.clear();
        self.variance.resize(names.len(), 0.0);
    }

    /// How many groups of lights there are.
    pub(crate) fn groups(&self) -> usize {
        self.groups
    }

    /// How many blocks there are.
    pub(crate) fn blocks(&self) -> usize {
        self.rows.len()
    }

    /// Whether a row's pixel is among the quarter of its block that trial rays go out from.
    pub(crate) fn is_trial(&self, row: usize) -> bool {
        self.trial[row]
    }

    /// Number of a row's block.
    pub(crate) fn block(&self, row: usize) -> usize {
        self.block[row] as usize
    }

    /// Learns from a ray to a group: what it brought over what could have been; 0 if it is blocked.
    pub(crate) fn note(&mut self, row: usize, group: usize, brought: f32) {
        let place = self.block(row) * self.groups + group;
        self.looked[place] += 1;
        self.brought[place] += brought * brought;
        self.found[row * self.groups + group] |= brought > 0.0;
        if brought > 0.0 {
            let block = self.block(row);
            self.arrived[block] += 1;
            self.squares[block] += brought * brought;
        }
    }

    /// Learns the variance of a row's rays.
    pub(crate) fn note_variance(&mut self, row: usize, variance: f32) {
        let block = self.block(row);
        self.rows[block] += 1;
        self.variance[block] += f64::from(variance);
    }

    /// Share of a group that counts for a row: at least all of it where its own rays have reached it.
    pub(crate) fn share(&self, row: usize, group: usize) -> f32 {
        let share = self.block_share(row, group);
        match self.found[row * self.groups + group] {
            true => share.max(1.0),
            false => share,
        }
    }

    /// Share of a group that counts for the block of a row, at least [`LEAST_SEEN`]; 1 where it has not
    /// looked. Rays are best shared out by the root of the mean square of what they bring: beside that of
    /// all rays of the block that nothing blocked, since materials send on less than they could.
    pub(crate) fn block_share(&self, row: usize, group: usize) -> f32 {
        let block = self.block(row);
        let place = block * self.groups + group;
        let usual = match self.arrived[block] {
            0 => 1.0,
            arrived => self.squares[block] / arrived as f32,
        };
        let (looked, brought) = (self.looked[place] + 1, self.brought[place] / usual + 1.0);
        (brought / looked as f32).sqrt().max(LEAST_SEEN)
    }

    /// Mean variance of the rays of a row's block.
    pub(crate) fn variance(&self, row: usize) -> f32 {
        let block = self.block(row);
        (self.variance[block] / f64::from(self.rows[block].max(1))) as f32
    }
}
