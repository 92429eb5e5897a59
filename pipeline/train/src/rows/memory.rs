//! Rows in memory, in a net's units.

use super::chunk::Chunk;
use super::units::{Input, Units};
use crate::net::simd::TILE_ROWS;
use crate::net::tile::{Batch, CHANNELS, Rows};
use rrf_field::inputs;
use rrf_metrics::channel_mean;
use std::ops::Range;

/// Rows in memory, in a net's units.
pub struct MemoryRows {
    /// One column an input.
    x: Vec<Vec<f32>>,
    target: [Vec<f64>; CHANNELS],
    gain: [Vec<f64>; CHANNELS],
    base: Vec<f64>,
}

impl MemoryRows {
    /// A range of rows, scaled.
    pub fn new(chunk: &Chunk, rows: Range<usize>, units: &Units) -> MemoryRows {
        let mut values = Vec::new();
        let mut scaled = |input: &Input| -> Vec<f32> {
            inputs::fill(input.id, &chunk.columns, &mut values);
            let values = &values[rows.clone()];
            let scaled = values.iter().map(|x| (x - input.offset) * input.scale);
            scaled.collect()
        };
        let mut result = MemoryRows {
            x: units.inputs.iter().map(&mut scaled).collect(),
            target: Default::default(),
            gain: Default::default(),
            base: Vec::with_capacity(rows.len()),
        };
        for row in rows {
            let (y, base) = (chunk.mean(row), chunk.base(row, units.divide_base));
            let mut zero = [0.0; CHANNELS];
            for c in 0..CHANNELS {
                let output = &units.output;
                let (scale, offset) = (f64::from(output.scale[c]), f64::from(output.offset[c]));
                let target = (y[c] / base[c] - offset) / scale;
                let used = base[c] > 0.0 && target.is_finite();
                result.target[c].push(if used { target } else { 0.0 });
                result.gain[c].push(if used { base[c] * scale } else { 0.0 });
                zero[c] = base[c] * offset;
            }
            result.base.push(channel_mean(zero));
        }
        result
    }

    /// How many residuals of a range of rows count.
    pub(crate) fn residuals(&self, range: Range<usize>) -> usize {
        let used = |gain: &Vec<f64>| gain[range.clone()].iter().filter(|g| **g > 0.0).count();
        self.gain.iter().map(used).sum()
    }

    /// Makes every cost over these rows no number: they could not be read.
    pub(crate) fn spoil(&mut self) {
        self.gain.iter_mut().for_each(|gain| gain.fill(f64::NAN));
    }

    /// A tile from `first` on that ends at `end` at the latest.
    pub(crate) fn load_until(&self, first: usize, end: usize, batch: &mut Batch) {
        let rows = TILE_ROWS.min(end.saturating_sub(first));
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

impl Rows for MemoryRows {
    fn len(&self) -> usize {
        self.base.len()
    }

    fn load(&self, first: usize, batch: &mut Batch) {
        self.load_until(first, self.len(), batch);
    }
}
