//! Rows that are read chunk by chunk, again at each pass, instead of held in memory.
//!
//! The steps ask for tiles in rising order; the chunk that a tile lies in is read, scaled, and
//! held until a tile of another one is asked for. Memory is that of one chunk, whatever the
//! number of rows; sums are over the same tiles in the same order as with rows in memory, so
//! the bits are the same.

use crate::prepare::{self, Input, OutputScale, Samples};
use crate::rows::MemoryRows;
use crate::simd::TILE;
use crate::tile::{Batch, Rows};
use rrf_field::columns::Columns;
use rrf_field::model::CellModel;
use std::cell::{Cell, RefCell};

/// Raw rows as they are read: columns and the two half estimates [W·sr⁻¹·m⁻²].
#[derive(Clone, Debug, Default)]
pub struct Chunk {
    /// Geometry and material.
    pub columns: Columns,
    /// Two independent estimates of each row's radiance.
    pub halves: [Vec<[f32; 3]>; 2],
}

/// Rows behind a function that reads them.
pub struct StreamedRows<'a, E, F: Fn(usize, usize) -> Result<Chunk, E>> {
    read: F,
    rows: usize,
    chunk: usize,
    units: &'a CellModel,
    /// The chunk at hand and its first row.
    held: RefCell<Option<(usize, MemoryRows)>>,
    failure: Cell<Option<E>>,
}

impl<'a, E, F: Fn(usize, usize) -> Result<Chunk, E>> StreamedRows<'a, E, F> {
    /// `rows` rows in the inputs and scales of `units`; `read(first, count)` reads `count` rows
    /// from row `first` on, fewer at the end. At least `chunk` rows are read at a time, in whole
    /// tiles.
    pub fn new(rows: usize, chunk: usize, units: &'a CellModel, read: F) -> StreamedRows<'a, E, F> {
        StreamedRows {
            read,
            rows,
            chunk: chunk.max(1).next_multiple_of(TILE),
            units,
            held: RefCell::new(None),
            failure: Cell::new(None),
        }
    }

    /// Why a chunk could not be read, if so. Its rows then count as NaN, so that the cost is no
    /// number and no step is taken.
    pub fn failure(&self) -> Option<E> {
        self.failure.take()
    }

    fn scaled(&self, first: usize) -> Option<MemoryRows> {
        let count = self.chunk.min(self.rows - first);
        let chunk = match (self.read)(first, count) {
            Ok(chunk) => chunk,
            Err(failure) => {
                self.failure.set(Some(failure));
                return None;
            }
        };
        let samples = Samples {
            rows: &chunk.columns,
            halves: [&chunk.halves[0], &chunk.halves[1]],
            validation: &vec![false; count],
        };
        samples.check().ok()?;
        let ids: Vec<u32> = (0..count as u32).collect();
        let units = self.units;
        let inputs = inputs(units, &chunk.columns);
        let output = OutputScale {
            scale: units.output_scale,
            offset: units.output_offset,
            constant: false,
        };
        Some(MemoryRows::new(
            &samples,
            &ids,
            &inputs,
            &output,
            units.divide_base,
        ))
    }
}

/// A model's inputs of some rows, with its offsets and scales.
fn inputs(units: &CellModel, columns: &Columns) -> Vec<Input> {
    let mut inputs = prepare::compute_inputs(&units.inputs, columns);
    let scales = units.input_offset.iter().zip(&units.input_scale);
    for (input, (offset, scale)) in inputs.iter_mut().zip(scales) {
        (input.offset, input.scale) = (*offset, *scale);
    }
    inputs
}

impl<E, F: Fn(usize, usize) -> Result<Chunk, E>> Rows for StreamedRows<'_, E, F> {
    fn len(&self) -> usize {
        self.rows
    }

    fn load(&self, first: usize, batch: &mut Batch) {
        let start = first / self.chunk * self.chunk;
        let mut held = self.held.borrow_mut();
        if held.as_ref().is_none_or(|(at, _)| *at != start) {
            // dropped before the next is read, so that there is never more than one
            *held = None;
            *held = self.scaled(start).map(|rows| (start, rows));
        }
        match held.as_ref() {
            Some((start, rows)) => rows.load(first - start, batch),
            None => {
                batch.rows = TILE.min(self.rows - first);
                batch.gain.iter_mut().for_each(|gain| gain.fill(f64::NAN));
            }
        }
    }
}
