//! Rows that are read from a file and scaled again at each pass, instead of held in memory.
//!
//! The steps ask for tiles in rising order; the window that a tile lies in is read, scaled, and
//! held until a tile beyond it is asked for. Memory is that of one window, whatever the number
//! of rows; sums are over the same tiles in the same order as with rows in memory, so the bits
//! are the same.

use super::memory::MemoryRows;
use super::scratch::{Scratch, WINDOW};
use super::units::Units;
use crate::net::simd::TILE_ROWS;
use crate::net::tile::{Batch, Rows};
use std::cell::RefCell;
use std::ops::Range;
use std::rc::Rc;

/// A range of the rows of a file.
pub(crate) struct StreamedRows<'a> {
    scratch: Rc<Scratch<'a>>,
    range: Range<usize>,
    units: Units,
    /// The window at hand and its first row.
    held: RefCell<Option<(usize, MemoryRows)>>,
}

impl<'a> StreamedRows<'a> {
    pub fn new(scratch: Rc<Scratch<'a>>, range: Range<usize>, units: Units) -> StreamedRows<'a> {
        StreamedRows {
            scratch,
            range,
            units,
            held: RefCell::new(None),
        }
    }

    pub fn len(&self) -> usize {
        self.range.len()
    }

    /// How many residuals of a range of rows count.
    pub fn residuals(&self, range: Range<usize>) -> usize {
        let windows = range.clone().step_by(WINDOW);
        let count = |first: usize| {
            let rows = self.scaled(first, WINDOW.min(range.end - first));
            rows.residuals(0..rows.len())
        };
        windows.map(count).sum()
    }

    /// A tile from `first` on that ends at `end` at the latest.
    pub fn load_until(&self, first: usize, end: usize, batch: &mut Batch) {
        let until = end.min(first + TILE_ROWS);
        let mut held = self.held.borrow_mut();
        let inside =
            |(start, rows): &(usize, MemoryRows)| *start <= first && until <= *start + rows.len();
        if !held.as_ref().is_some_and(inside) {
            // dropped before the next is read, so that there is never more than one
            *held = None;
        }
        let window = WINDOW.min(self.len().saturating_sub(first));
        let (start, rows) = held.get_or_insert_with(|| (first, self.scaled(first, window)));
        rows.load_until(first - *start, end - *start, batch);
    }

    fn scaled(&self, first: usize, count: usize) -> MemoryRows {
        let chunk = self.scratch.read(self.range.start + first, count);
        let mut rows = MemoryRows::new(&chunk, 0..count, &self.units);
        if self.scratch.failed() {
            rows.spoil();
        }
        rows
    }
}
