//! A cell's rows: as they come in ([`samples`]), as they are used ([`chunk`]), in random order and in
//! memory or in a file ([`order`], [`scratch`]), and in the units of a net ([`memory`], [`streamed`]).

pub mod chunk;
pub(crate) mod memory;
pub(crate) mod order;
pub mod samples;
pub(crate) mod scratch;
mod streamed;
pub mod units;

use crate::net::tile::{Batch, Rows};
use memory::MemoryRows;
use order::OrderedRows;
use std::ops::Range;
use streamed::StreamedRows;
use units::Units;

/// Rows of a cell that are trained on, or those held out.
pub(crate) enum CellRows<'a> {
    Held(MemoryRows),
    Streamed(StreamedRows<'a>),
}

impl<'a> CellRows<'a> {
    /// A range of a cell's rows.
    pub fn new(ordered: &OrderedRows<'a>, range: Range<usize>, units: &Units) -> CellRows<'a> {
        match ordered {
            OrderedRows::Held(chunk) => CellRows::Held(MemoryRows::new(chunk, range, units)),
            OrderedRows::Spilled(scratch) => {
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
