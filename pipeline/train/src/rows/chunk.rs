//! Raw rows as they are used: geometry, material and two half estimates.

use super::samples::Samples;
use crate::net::tile::CHANNELS;
use rrf_field::columns::{self, Columns};

/// Raw rows of a cell, or some of them.
#[derive(Clone, Debug, Default)]
pub struct Chunk {
    /// Geometry and material.
    pub columns: Columns,
    /// Two independent estimates of each row's radiance, W·sr⁻¹·m⁻².
    pub halves: [Vec<[f32; 3]>; 2],
}

/// Numbers a row: the raw columns and both halves.
pub(crate) const WIDTH: usize = columns::COUNT + 2 * CHANNELS;

impl Chunk {
    /// How many rows.
    pub fn len(&self) -> usize {
        self.columns.len()
    }

    /// The rows named, in the order named.
    pub(crate) fn gathered(samples: &Samples, rows: impl Iterator<Item = u32> + Clone) -> Chunk {
        let places = || rows.clone().map(|row| row as usize);
        Chunk {
            columns: Columns {
                columns: std::array::from_fn(|c| {
                    places().map(|row| samples.rows.columns[c][row]).collect()
                }),
            },
            halves: samples
                .halves
                .map(|half| places().map(|row| half[row]).collect()),
        }
    }

    /// Mean of the two halves.
    pub fn mean(&self, row: usize) -> [f64; CHANNELS] {
        let (a, b) = (self.halves[0][row], self.halves[1][row]);
        std::array::from_fn(|c| 0.5 * (f64::from(a[c]) + f64::from(b[c])))
    }

    /// Base colour where the target is divided by it, otherwise 1.
    pub fn base(&self, row: usize, divide: bool) -> [f64; CHANNELS] {
        if divide {
            self.columns.vec3(columns::BASE, row).map(f64::from)
        } else {
            [1.0; CHANNELS]
        }
    }

    /// One row as flat numbers.
    pub(crate) fn row(&self, row: usize) -> [f32; WIDTH] {
        let mut numbers = [0.0; WIDTH];
        let halves = self.halves.iter().flat_map(|half| half[row]);
        let columns = self.columns.columns.iter().map(|column| column[row]);
        for (number, value) in numbers.iter_mut().zip(columns.chain(halves)) {
            *number = value;
        }
        numbers
    }

    /// Appends a row of flat numbers.
    pub(crate) fn push(&mut self, numbers: &[f32; WIDTH]) {
        let (columns, halves) = numbers.split_at(columns::COUNT);
        for (column, value) in self.columns.columns.iter_mut().zip(columns) {
            column.push(*value);
        }
        for (half, y) in self.halves.iter_mut().zip(halves.chunks_exact(CHANNELS)) {
            half.push(std::array::from_fn(|c| y[c]));
        }
    }
}
