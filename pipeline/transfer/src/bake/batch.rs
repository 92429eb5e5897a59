//! Rows of a few surfaces, traced and lit.

use super::config::TransferConfig;
use super::lighting::Lighting;
use crate::TransferError;
use crate::ensemble::Ensemble;
use crate::patches::Patches;
use crate::query::TransferQuery;
use crate::reflectance::{LEAST, Reflectances};
use crate::regression::RowTable;
use crate::rows::{RowPoint, TransferRows, trace_rows};
use crate::tracing::{Stream, Tracer, unless_halted};
use multiversion::multiversion;
use rayon::prelude::*;

/// All that rows are traced and lit by.
pub(crate) struct BatchTracer<'a> {
    pub(crate) tracer: &'a Tracer<'a>,
    pub(crate) patches: &'a Patches,
    pub(crate) lighting: &'a Lighting,
    pub(crate) reflectances: &'a Reflectances,
    pub(crate) config: &'a TransferConfig,
}

/// Rows of a few surfaces: sparse, and under the ensemble.
pub(crate) struct Batch {
    pub(crate) sparse: TransferRows,
    pub(crate) table: RowTable,
}

impl Batch {
    /// Appends further rows.
    pub(crate) fn append(&mut self, other: Batch) {
        self.sparse.append(other.sparse);
        self.table.append(other.table);
    }
}

impl BatchTracer<'_> {
    /// Traces points; row i draws at index `first + i` of the stream.
    pub(crate) fn trace(
        &self,
        points: &[RowPoint],
        stream: Stream,
        first: u64,
    ) -> Result<Batch, TransferError> {
        let paths = &self.config.paths;
        let sparse = trace_rows(self.tracer, self.patches, points, paths, stream, first)?;
        let queries: Vec<TransferQuery> = (points.par_iter())
            .map(|point| TransferQuery::of_row(self.tracer, point))
            .collect();
        let judging = |row: usize| {
            let word = stream.part(7).block(first + row as u64, 0, 0)[0];
            self.config.judging > 0 && word.is_multiple_of(self.config.judging)
        };
        let lights = self.lighting.ensemble.lights;
        let mut lit = vec![0.0f32; 6 * lights * sparse.len()];
        lit.par_chunks_mut(6 * lights.max(1))
            .enumerate()
            .for_each(|(row, lit)| {
                if self.tracer.is_halted() {
                    return;
                }
                light_row(&sparse, row, &self.lighting.ensemble, lit);
                let scales = scales(self.reflectances, &queries[row]);
                for (part, scale) in lit.chunks_exact_mut(3 * lights).zip(scales) {
                    part.iter_mut().for_each(|x| *x *= scale);
                }
            });
        unless_halted(self.tracer)?;
        let level = |row: usize| {
            let half = |half| {
                let value = sparse.apply(row, half, &self.lighting.mean);
                value.coloured(queries[row].base_color).element_sum() / 3.0
            };
            0.5 * (half(0) + half(1))
        };
        let judged = |row: usize| -> Vec<f32> {
            if !judging(row) || self.tracer.is_halted() {
                return Vec::new();
            }
            let colour = queries[row].base_color;
            (self.lighting.judges.iter())
                .flat_map(|light| [0, 1].map(|half| sparse.apply(row, half, light)))
                .flat_map(|value| value.coloured(colour).to_array())
                .collect()
        };
        let rows = 0..sparse.len();
        let table = RowTable {
            lights,
            lit,
            levels: rows.clone().into_par_iter().map(level).collect(),
            judged: rows.into_par_iter().map(judged).collect(),
            queries,
        };
        Ok(Batch { sparse, table })
    }
}

/// 1 / the directional albedo of both parts of a row, 0 where there is none.
pub(crate) fn scales(reflectances: &Reflectances, query: &TransferQuery) -> [f32; 2] {
    let albedos = reflectances.at(query.surface.material, query.facing());
    albedos.map(|a| if a > LEAST { 1.0 / a } else { 0.0 })
}

/// The mean of a row's halves under each light: both parts, channels apart, lights together.
#[multiversion(targets("x86_64+avx+avx2+fma+avx512f+avx512vl", "x86_64+avx+avx2+fma"))]
fn light_row(rows: &TransferRows, row: usize, ensemble: &Ensemble, lit: &mut [f32]) {
    let lights = ensemble.lights;
    for half in 0..2 {
        let (columns, entries) = rows.half(row, half);
        for (&column, entry) in columns.iter().zip(entries) {
            let e = ensemble.row(column);
            let values = [entry.base, entry.constant];
            for (part, value) in lit.chunks_exact_mut(3 * lights).zip(values) {
                for (channel, sum) in part.chunks_exact_mut(lights).enumerate() {
                    let value = 0.5 * value[channel];
                    if value != 0.0 {
                        sum.iter_mut().zip(e).for_each(|(s, e)| *s += value * e);
                    }
                }
            }
        }
    }
}
