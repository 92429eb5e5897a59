//! Random combinations of smoothed rows, by which a light's residual is measured.

use super::batch::{Batch, scales};
use super::compress::DenseRead;
use crate::model::SKETCHES;
use crate::reflectance::Reflectances;
use crate::regression::Combination;
use crate::tracing::Stream;
use glam::Vec3;
use rayon::prelude::*;

/// A smoothed row that takes part in the combinations.
#[derive(Clone, Debug)]
pub(crate) struct SketchRow {
    /// The row of the batch that it lies at.
    pub(crate) row: u32,
    /// Weights of the rows' parts in it.
    pub(crate) parts: [Option<Combination>; 2],
    /// Weights of its own parts in its weighted radiance.
    pub(crate) shares: [Vec3; 2],
}

/// Random combinations of weighted rows.
pub(crate) struct Sketch {
    columns: usize,
    /// Shape [sketches, columns].
    sums: Vec<f32>,
}

/// Weight of a row in a combination: its sign there.
pub(crate) fn sign(stream: Stream, row: u32, sketch: usize) -> f32 {
    let word = stream.block(u64::from(row), 0, 0)[0];
    if word >> sketch & 1 == 0 { 1.0 } else { -1.0 }
}

impl Sketch {
    /// From sums so far, shape [sketches, columns].
    pub(crate) fn of(columns: usize, sums: Vec<f32>) -> Sketch {
        Sketch { columns, sums }
    }

    /// The sums so far.
    pub(crate) fn into_sums(self) -> Vec<f32> {
        self.sums
    }

    /// Adds smoothed rows of a batch, the mean of their channels.
    pub(crate) fn add(
        &mut self,
        batch: &Batch,
        rows: &[SketchRow],
        reflectances: &Reflectances,
        stream: Stream,
    ) {
        let columns = self.columns.max(1);
        let sketches = self.sums.par_chunks_mut(columns).enumerate();
        sketches.for_each(|(sketch, sums)| {
            for own in rows {
                let by = sign(stream, own.row, sketch) / 6.0;
                for (part, fit) in own.parts.iter().enumerate() {
                    let Some(fit) = fit else { continue };
                    for (&raw, &factor) in fit.rows.iter().zip(&fit.factors[0]) {
                        let query = &batch.table.queries[raw as usize];
                        let scale = scales(reflectances, query)[part] * factor * by;
                        let share = own.shares[part] * scale;
                        for half in 0..2 {
                            let (columns, entries) = batch.sparse.half(raw as usize, half);
                            for (&column, entry) in columns.iter().zip(entries) {
                                let value = [entry.base, entry.constant][part];
                                sums[column as usize] += value.dot(share);
                            }
                        }
                    }
                }
            }
        });
    }

    /// The combinations' read of a light.
    pub(crate) fn read(&self) -> DenseRead {
        let weights = (0..self.columns).flat_map(|column| {
            (0..SKETCHES).map(move |sketch| self.sums[sketch * self.columns + column])
        });
        DenseRead {
            rank: SKETCHES,
            weights: weights.collect(),
        }
    }
}
