//! A cell's rows in the units of its net: in memory, or scaled anew at each pass.

use crate::chunk::Chunk;
use crate::ordered::Ordered;
use crate::prepare::{Input, OutputScale, luminance};
use crate::simd::TILE;
use crate::streamed::StreamedRows;
use crate::tile::{Batch, CHANNELS, Rows};
use rrf_field::model;
use std::ops::Range;

/// What raw rows become a net's rows by.
#[derive(Clone, Debug)]
pub struct Units {
    /// Inputs and their scales.
    pub inputs: Vec<Input>,
    /// Scale of the targets.
    pub output: OutputScale,
    /// Targets are divided by the base colour.
    pub divide_base: bool,
}

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
            model::fill(input.id, &chunk.columns, &mut values);
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
            result.base.push(luminance(zero));
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

impl Rows for MemoryRows {
    fn len(&self) -> usize {
        self.base.len()
    }

    fn load(&self, first: usize, batch: &mut Batch) {
        self.load_until(first, self.len(), batch);
    }
}

/// Rows of a cell that are trained on, or those held out.
pub(crate) enum CellRows<'a> {
    Held(MemoryRows),
    Streamed(StreamedRows<'a>),
}

impl<'a> CellRows<'a> {
    /// A range of a cell's rows.
    pub fn new(ordered: &Ordered<'a>, range: Range<usize>, units: &Units) -> CellRows<'a> {
        match ordered {
            Ordered::Held(chunk) => CellRows::Held(MemoryRows::new(chunk, range, units)),
            Ordered::Spilled(scratch) => {
                CellRows::Streamed(StreamedRows::new(scratch.clone(), range, units.clone()))
            }
        }
    }

    pub fn len(&self) -> usize {
        match self {
            CellRows::Held(rows) => rows.len(),
            CellRows::Streamed(rows) => rows.len(),
        }
    }

    /// The first `rows` rows.
    pub fn first(&self, rows: usize) -> Part<'_> {
        self.part(0..rows)
    }

    /// Some rows in their order.
    pub fn part(&self, range: Range<usize>) -> Part<'_> {
        let end = range.end.min(self.len());
        Part {
            of: self,
            first: range.start.min(end),
            end,
        }
    }

    /// Takes an input's column out.
    pub fn take_input(&mut self, place: usize) -> TakenColumn {
        match self {
            CellRows::Held(rows) => TakenColumn::Values(rows.x.remove(place)),
            CellRows::Streamed(rows) => TakenColumn::Input(rows.take_input(place)),
        }
    }

    /// Puts it back.
    pub fn put_input(&mut self, place: usize, column: TakenColumn) {
        match (self, column) {
            (CellRows::Held(rows), TakenColumn::Values(values)) => rows.x.insert(place, values),
            (CellRows::Streamed(rows), TakenColumn::Input(input)) => rows.put_input(place, input),
            // a column only ever goes back to the rows that it was taken from
            _ => (),
        }
    }
}

/// An input taken out of rows.
pub(crate) enum TakenColumn {
    Values(Vec<f32>),
    Input(Input),
}

/// A stretch of some rows.
pub(crate) struct Part<'a> {
    of: &'a CellRows<'a>,
    first: usize,
    end: usize,
}

impl Part<'_> {
    /// How many residuals count.
    pub fn residuals(&self) -> usize {
        match self.of {
            CellRows::Held(rows) => rows.residuals(self.first..self.end),
            CellRows::Streamed(rows) => rows.residuals(self.first..self.end),
        }
    }
}

impl Rows for Part<'_> {
    fn len(&self) -> usize {
        self.end - self.first
    }

    fn held(&self) -> bool {
        matches!(self.of, CellRows::Held(_))
    }

    fn load(&self, first: usize, batch: &mut Batch) {
        let first = self.first + first;
        match self.of {
            CellRows::Held(rows) => rows.load_until(first, self.end, batch),
            CellRows::Streamed(rows) => rows.load_until(first, self.end, batch),
        }
    }
}
