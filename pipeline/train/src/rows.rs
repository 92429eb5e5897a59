//! A cell's rows in memory, in the units of its net.

use crate::prepare::{Input, OutputScale, Samples, luminance};
use crate::simd::TILE;
use crate::tile::{Batch, CHANNELS, Rows};

/// Rows in memory, in a net's units.
pub struct MemoryRows {
    /// One column an input.
    pub(crate) x: Vec<Vec<f32>>,
    target: [Vec<f64>; CHANNELS],
    gain: [Vec<f64>; CHANNELS],
    base: Vec<f64>,
}

impl MemoryRows {
    /// The rows named, scaled.
    pub fn new(
        samples: &Samples,
        rows: &[u32],
        inputs: &[Input],
        output: &OutputScale,
        divide: bool,
    ) -> MemoryRows {
        let scaled = |input: &Input| {
            rows.iter()
                .map(|&r| (input.values[r as usize] - input.offset) * input.scale)
                .collect()
        };
        let mut result = MemoryRows {
            x: inputs.iter().map(scaled).collect(),
            target: Default::default(),
            gain: Default::default(),
            base: Vec::with_capacity(rows.len()),
        };
        for &row in rows {
            let (y, base) = (
                samples.mean(row as usize),
                samples.base(row as usize, divide),
            );
            let mut zero = [0.0; CHANNELS];
            for c in 0..CHANNELS {
                let (scale, offset) = (f64::from(output.scale[c]), f64::from(output.offset[c]));
                let target = (y[c] / base[c] - offset) / scale;
                let used = base[c] > 0.0 && target.is_finite();
                result.target[c].push(if used { target } else { 0.0 });
                result.gain[c].push(if used { base[c] * scale } else { 0.0 });
                zero[c] = base[c] * offset;
            }
            result.base.push(luminance(zero));
        }
        result
    }

    /// The first `rows` rows.
    pub fn first(&self, rows: usize) -> Part<'_> {
        self.part(0..rows)
    }

    /// Some rows in their order.
    pub fn part(&self, range: std::ops::Range<usize>) -> Part<'_> {
        let end = range.end.min(self.len());
        Part {
            of: self,
            first: range.start.min(end),
            end,
        }
    }
}

impl Rows for MemoryRows {
    fn len(&self) -> usize {
        self.base.len()
    }

    fn load(&self, first: usize, batch: &mut Batch) {
        self.load_until(first, self.len(), batch);
    }
}

impl MemoryRows {
    fn load_until(&self, first: usize, end: usize, batch: &mut Batch) {
        let rows = TILE.min(end.saturating_sub(first));
        batch.rows = rows;
        for (lane, column) in batch.x.iter_mut().zip(&self.x) {
            for (x, value) in lane.iter_mut().zip(&column[first..first + rows]) {
                *x = f64::from(*value);
            }
        }
        for c in 0..CHANNELS {
            batch.target[c][..rows].copy_from_slice(&self.target[c][first..first + rows]);
            batch.gain[c][..rows].copy_from_slice(&self.gain[c][first..first + rows]);
        }
        batch.base[..rows].copy_from_slice(&self.base[first..first + rows]);
    }
}

/// A stretch of some rows.
pub struct Part<'a> {
    of: &'a MemoryRows,
    first: usize,
    end: usize,
}

impl Part<'_> {
    /// How many residuals count.
    pub fn residuals(&self) -> usize {
        let used = |gain: &Vec<f64>| {
            let gain = &gain[self.first..self.end];
            gain.iter().filter(|g| **g > 0.0).count()
        };
        self.of.gain.iter().map(used).sum()
    }
}

impl Rows for Part<'_> {
    fn len(&self) -> usize {
        self.end - self.first
    }

    fn load(&self, first: usize, batch: &mut Batch) {
        self.of.load_until(self.first + first, self.end, batch);
    }
}
