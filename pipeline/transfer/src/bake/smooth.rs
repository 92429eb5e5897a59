//! The rows of a cell, smoothed by local fits.

use crate::regression::{Combination, LocalFits, LocalScratch, RowTable};

/// Local fits at a cell's rows.
pub(crate) struct Smoothed {
    /// Fits of both parts at each row; none of parts that the material has not.
    pub(crate) combinations: Vec<[Option<Combination>; 2]>,
    /// Shape [rows, 2 parts, 3, lights].
    values: Vec<f32>,
    stride: usize,
}

impl Smoothed {
    /// Fits at each of the rows the parts that there are; `view` says which depend on the viewer.
    pub(crate) fn new(
        table: &RowTable,
        fits: &LocalFits,
        rows: &[u32],
        has: [bool; 2],
        view: [bool; 2],
    ) -> Smoothed {
        let mut scratch = LocalScratch::default();
        let stride = table.stride();
        let mut smoothed = Smoothed {
            combinations: Vec::with_capacity(rows.len()),
            values: Vec::with_capacity(2 * stride * rows.len()),
            stride,
        };
        for &row in rows {
            let query = &table.queries[row as usize];
            let own = [0, 1].map(|part: usize| {
                let fit = || fits.at(query, view[part], None, &mut scratch);
                has[part].then(fit).flatten()
            });
            for (part, fit) in own.iter().enumerate() {
                match fit {
                    Some(fit) => smoothed.values.extend(fit.apply(table, part, 0)),
                    None => smoothed.values.resize(smoothed.values.len() + stride, 0.0),
                }
            }
            smoothed.combinations.push(own);
        }
        smoothed
    }

    /// One part of a row, shape [3, lights].
    pub(crate) fn part(&self, row: usize, part: usize) -> &[f32] {
        let first = (2 * row + part) * self.stride;
        &self.values[first..first + self.stride]
    }
}
