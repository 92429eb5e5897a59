//! A cell's two parts, exact until it is known which directions are kept.

use crate::model::PartFit;

/// Both parts of a cell, packed, beside what they were packed from.
pub(crate) struct ExactParts {
    pub(crate) fits: [PartFit; 2],
    exact: [Vec<f32>; 2],
    rank: usize,
}

impl ExactParts {
    /// Parts whose exact numbers are rows of `rank` directions by 3 channels.
    pub(super) fn new(parts: [(PartFit, Vec<f32>); 2], rank: usize) -> ExactParts {
        let [(base, base_numbers), (constant, constant_numbers)] = parts;
        let mut parts = ExactParts {
            fits: [base, constant],
            exact: [base_numbers, constant_numbers],
            rank,
        };
        parts.pack();
        parts
    }

    /// Multiplies what the parts make of each direction.
    pub(super) fn scale(&mut self, factors: &[Vec<f32>; 2]) {
        for (exact, factors) in self.exact.iter_mut().zip(factors) {
            for row in exact.chunks_exact_mut(3 * self.rank.max(1)) {
                for (own, by) in row.chunks_exact_mut(3).zip(factors) {
                    own.iter_mut().for_each(|x| *x *= by);
                }
            }
        }
        self.pack();
    }

    /// Leaves out all other directions.
    pub(super) fn keep(&mut self, kept: &[usize]) {
        for exact in &mut self.exact {
            let rows = exact.chunks_exact(3 * self.rank.max(1));
            let of_row = |row: &[f32]| -> Vec<f32> {
                let own = kept.iter().flat_map(|&k| &row[3 * k..3 * k + 3]);
                own.copied().collect()
            };
            *exact = rows.flat_map(of_row).collect();
        }
        self.rank = kept.len();
        self.pack();
    }

    fn pack(&mut self) {
        for (fit, exact) in self.fits.iter_mut().zip(&self.exact) {
            fit.pack(exact, 3 * self.rank);
        }
    }
}
