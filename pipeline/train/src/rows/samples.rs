//! A cell's samples as they come in, and which of them can be used.

use crate::error::TrainError;
use rrf_field::columns::{self, Columns};
use rrf_field::inputs;

/// A cell's samples as they come in.
#[derive(Clone, Copy)]
pub struct Samples<'a> {
    /// Geometry and material.
    pub rows: &'a Columns,
    /// Two independent estimates of the radiance of each row, W·sr⁻¹·m⁻².
    pub halves: [&'a [[f32; 3]]; 2],
    /// Whether a row is kept back for validation.
    pub validation: &'a [bool],
}

impl Samples<'_> {
    /// All lengths agree.
    pub fn check(&self) -> Result<(), TrainError> {
        let expected = self.rows.len();
        let lengths = [
            ("half 1", self.halves[0].len()),
            ("half 2", self.halves[1].len()),
            ("validation", self.validation.len()),
        ];
        let columns = self.rows.columns.iter().map(Vec::len);
        let columns = columns::NAMES.iter().copied().zip(columns);
        for (what, found) in lengths.into_iter().chain(columns) {
            if found != expected {
                return Err(TrainError::Length {
                    what,
                    found,
                    expected,
                });
            }
        }
        Ok(())
    }
}

/// Which rows hold a used number that is NaN or infinite, or a negative base colour.
pub(crate) fn unusable(samples: &Samples, ids: &[u8], divide_base: bool) -> Vec<bool> {
    let finite = |y: [f32; 3]| y.iter().all(|y| y.is_finite());
    let bad = |row: usize| {
        let base = samples.rows.vec3(columns::BASE, row);
        !(finite(samples.halves[0][row]) && finite(samples.halves[1][row]))
            || (divide_base && !base.iter().all(|b| *b >= 0.0 && b.is_finite()))
    };
    let mut unusable: Vec<bool> = (0..samples.rows.len()).map(bad).collect();
    let mut values = Vec::new();
    for &id in ids {
        inputs::fill(id, samples.rows, &mut values);
        for (bad, x) in unusable.iter_mut().zip(&values) {
            *bad |= !x.is_finite();
        }
    }
    unusable
}
