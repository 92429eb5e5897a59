//! A cell's raw rows in the order that its fit goes through them: those trained on, then those
//! held out, each in an order that is random but depends on nothing except (seed, cell, row).

use super::chunk::Chunk;
use super::samples::{Samples, unusable};
use super::scratch::{Scratch, WINDOW};
use rrf_sampling::Stream;
use std::ops::Range;
use std::rc::Rc;

/// Where the rows are.
pub(crate) enum OrderedRows<'a> {
    Held(Box<Chunk>),
    Spilled(Rc<Scratch<'a>>),
}

impl OrderedRows<'_> {
    /// Hands on the rows of a range, some at a time, in their order: what is at hand and where
    /// in it the rows are.
    pub fn each(&self, range: Range<usize>, mut see: impl FnMut(&Chunk, Range<usize>)) {
        match self {
            OrderedRows::Held(chunk) => see(chunk, range),
            OrderedRows::Spilled(scratch) => {
                for first in range.clone().step_by(WINDOW) {
                    let count = WINDOW.min(range.end - first);
                    see(&scratch.read(first, count), 0..count);
                }
            }
        }
    }

    /// Shows `count` rows from `first` on: what is at hand and where in it the first one is.
    pub fn show<T>(&self, first: usize, count: usize, see: impl FnOnce(&Chunk, usize) -> T) -> T {
        match self {
            OrderedRows::Held(chunk) => see(chunk, first),
            OrderedRows::Spilled(scratch) => scratch.show(first, count, see),
        }
    }
}

/// Index of the stream that rows are ordered by; starts of nets count from 0.
const ORDER: u64 = 1 << 63;

/// Finds out which rows are used, and in which order, from rows that come piece by piece.
pub(crate) struct Order {
    shuffle: Option<Stream>,
    rows: u32,
    /// Key and row of what is trained on and of what is held out.
    used: [Vec<(u32, u32)>; 2],
    quarantined: Vec<u32>,
}

/// Rows by place in the cell, in the order of their use.
pub(crate) struct Uses {
    /// Rows of the cell.
    pub rows: usize,
    pub train: Vec<u32>,
    pub validation: Vec<u32>,
    /// Rows that are not used.
    pub quarantined: Vec<u32>,
}

impl Order {
    /// Without a stream the rows stay as they come in.
    pub fn new(shuffle: Option<Stream>) -> Order {
        Order {
            shuffle,
            rows: 0,
            used: Default::default(),
            quarantined: Vec::new(),
        }
    }

    /// The cell's next rows, which will be read as the inputs `ids`.
    pub fn add(&mut self, samples: &Samples, ids: &[u8], divide_base: bool) {
        let bad = unusable(samples, ids, divide_base);
        for (bad, held_out) in bad.iter().zip(samples.validation) {
            let row = self.rows;
            self.rows += 1;
            if *bad {
                self.quarantined.push(row);
                continue;
            }
            let key = |s: &Stream| s.block(ORDER | u64::from(row), 0, 0)[0];
            let key = self.shuffle.as_ref().map_or(0, key);
            self.used[usize::from(*held_out)].push((key, row));
        }
    }

    pub fn finish(self) -> Uses {
        let [train, validation] = self.used.map(|mut used| {
            used.sort_unstable();
            used.into_iter().map(|(_, row)| row).collect()
        });
        Uses {
            rows: self.rows as usize,
            train,
            validation,
            quarantined: self.quarantined,
        }
    }
}

impl Uses {
    /// Rows that are used, in the order of their use.
    pub fn in_order(&self) -> impl Iterator<Item = u32> + Clone + '_ {
        self.train.iter().chain(&self.validation).copied()
    }

    /// Where each row of the cell is used, or none where it is not.
    pub fn places(&self) -> Vec<Option<std::num::NonZeroU32>> {
        let mut places = vec![None; self.rows];
        for (place, row) in (1..).zip(self.in_order()) {
            if let Some(slot) = places.get_mut(row as usize) {
                *slot = std::num::NonZeroU32::new(place);
            }
        }
        places
    }
}
