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

/// Asks whether a fit should give up; none for never.
pub type Halt<'a> = Option<&'a (dyn Fn() -> bool + Sync)>;

/// Rows of a cell that are trained on, or those held out.
pub(crate) struct CellRows<'a> {
    kept: Kept<'a>,
    halt: Halt<'a>,
}

enum Kept<'a> {
    Held(MemoryRows),
    Streamed(StreamedRows<'a>),
}

impl<'a> CellRows<'a> {
    /// A range of a cell's rows.
    pub fn new(
        ordered: &OrderedRows<'a>,
        range: Range<usize>,
        units: &Units,
        halt: Halt<'a>,
    ) -> CellRows<'a> {
        let kept = match ordered {
            OrderedRows::Held(chunk) => Kept::Held(MemoryRows::new(chunk, range, units)),
            OrderedRows::Spilled(scratch) => {
                Kept::Streamed(StreamedRows::new(scratch.clone(), range, units.clone()))
            }
        };
        CellRows { kept, halt }
    }

    pub fn len(&self) -> usize {
        match &self.kept {
            Kept::Held(rows) => rows.len(),
            Kept::Streamed(rows) => rows.len(),
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
        match &self.of.kept {
            Kept::Held(rows) => rows.residuals(self.first..self.end),
            Kept::Streamed(rows) => rows.residuals(self.first..self.end),
        }
    }
}

impl Rows for Part<'_> {
    fn len(&self) -> usize {
        self.end - self.first
    }

    fn held(&self) -> bool {
        matches!(self.of.kept, Kept::Held(_))
    }

    fn halted(&self) -> bool {
        self.of.halt.is_some_and(|halt| halt())
    }

    fn load(&self, first: usize, batch: &mut Batch) {
        let first = self.first + first;
        match &self.of.kept {
            Kept::Held(rows) => rows.load_until(first, self.end, batch),
            Kept::Streamed(rows) => rows.load_until(first, self.end, batch),
        }
    }
}
