//! A cell's rows in memory, in the units of its net.

use crate::prepare::{Input, OutputScale, Samples, luminance};
use crate::simd::TILE;
use crate::tile::{Batch, CHANNELS, Rows};

/// Rows in memory, in a net's units.
pub struct MemoryRows {
    /// One column an input.
    x: Vec<Vec<f32>>,
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

    /// How many residuals of the first `rows` rows count.
    pub fn residuals(&self, rows: usize) -> usize {
        let used = |gain: &Vec<f64>| gain.iter().take(rows).filter(|g| **g > 0.0).count();
        self.gain.iter().map(used).sum()
    }

    /// The first `rows` rows.
    pub fn first(&self, rows: usize) -> FirstRows<'_> {
        FirstRows {
            of: self,
            rows: rows.min(self.len()),
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

/// The leading part of some rows.
pub struct FirstRows<'a> {
    of: &'a MemoryRows,
    rows: usize,
}

impl Rows for FirstRows<'_> {
    fn len(&self) -> usize {
        self.rows
    }

    fn load(&self, first: usize, batch: &mut Batch) {
        self.of.load_until(first, self.rows, batch);
    }
}
