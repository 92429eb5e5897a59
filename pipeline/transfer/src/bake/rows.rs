//! Rows traced and projected, a few thousand at a time.

use super::config::TransferConfig;
use crate::TransferError;
use crate::basis::{Basis, Ensemble};
use crate::patches::Patches;
use crate::query::TransferQuery;
use crate::reflectance::{LEAST, Reflectances};
use crate::regression::RowTable;
use crate::rows::{RowPoint, TransferRows, trace_rows};
use crate::tracing::{Stream, Tracer};
use glam::Vec3;
use rayon::prelude::*;

/// Rows that are held with all their columns at a time.
const AT_ONCE: usize = 2_048;

/// All that rows are projected by.
pub(crate) struct Projector<'a> {
    pub(crate) tracer: &'a Tracer<'a>,
    pub(crate) patches: &'a Patches,
    pub(crate) basis: &'a Basis,
    pub(crate) reflectances: &'a Reflectances,
    /// Mean irradiance over the ensemble.
    pub(crate) mean: Vec<Vec3>,
    /// Irradiances of the lights that judge.
    pub(crate) judges: &'a [Vec<Vec3>],
    pub(crate) config: &'a TransferConfig,
}

impl Projector<'_> {
    /// Traces and projects all points; row i draws at index `first + i`.
    pub(crate) fn trace(
        &self,
        points: &[RowPoint],
        stream: Stream,
        first: u64,
        halt: &(dyn Fn() -> bool + Sync),
    ) -> Result<RowTable, TransferError> {
        let mut table = RowTable {
            rank: self.basis.rank,
            ..RowTable::default()
        };
        for (chunk, points) in points.chunks(AT_ONCE).enumerate() {
            if halt() {
                return Err(TransferError::Halted);
            }
            let at = first + (chunk * AT_ONCE) as u64;
            let rows = trace_rows(
                self.tracer,
                self.patches,
                points,
                &self.config.paths,
                stream,
                at,
            )?;
            table.extend(self.project(points, &rows, stream, at));
        }
        Ok(table)
    }

    /// Projects rows and says which of them judge.
    fn project(
        &self,
        points: &[RowPoint],
        rows: &TransferRows,
        stream: Stream,
        first: u64,
    ) -> RowTable {
        let queries: Vec<TransferQuery> = (points.par_iter())
            .map(|point| TransferQuery::of_row(self.tracer, point))
            .collect();
        let judging = |row: usize| {
            let word = stream.part(7).block(first + row as u64, 0, 0)[0];
            self.config.judging > 0 && word % self.config.judging == 0
        };
        let projected: Vec<[Vec<f32>; 2]> = (0..rows.len())
            .into_par_iter()
            .map(|row| [0, 1].map(|half| self.half(&queries[row], rows, row, half)))
            .collect();
        let level = |row: usize, half: usize| {
            let value = rows.apply(row, half, &self.mean);
            value.coloured(queries[row].base_color).element_sum() / 3.0
        };
        let judged = |row: usize| -> Vec<f32> {
            if !judging(row) {
                return Vec::new();
            }
            let colour = queries[row].base_color;
            (self.judges.iter())
                .flat_map(|light| [0, 1].map(|half| rows.apply(row, half, light)))
                .flat_map(|value| value.coloured(colour).to_array())
                .collect()
        };
        let ids = 0..rows.len();
        let [first_half, second_half]: [Vec<f32>; 2] =
            [0, 1].map(|half| projected.iter().flat_map(|p| &p[half]).copied().collect());
        RowTable {
            rank: self.basis.rank,
            halves: [first_half, second_half],
            levels: (ids.clone().into_par_iter())
                .map(|row| [0, 1].map(|half| level(row, half)))
                .collect(),
            judged: ids.into_par_iter().map(judged).collect(),
            paths: vec![self.config.paths.paths; rows.len()],
            queries,
        }
    }

    /// One half of a row in the basis, both parts over their albedos.
    fn half(
        &self,
        query: &TransferQuery,
        rows: &TransferRows,
        row: usize,
        half: usize,
    ) -> Vec<f32> {
        let entries = self.basis.project(rows, row, half);
        let albedos = (self.reflectances).at(query.surface.material, query.facing());
        let [base, constant] = albedos.map(|a| if a > LEAST { 1.0 / a } else { 0.0 });
        let bases = entries.iter().flat_map(|e| (e.base * base).to_array());
        let constants = (entries.iter()).flat_map(|e| (e.constant * constant).to_array());
        bases.chain(constants).collect()
    }
}

/// Coefficients of every light of an ensemble in a basis, weighted; shape [rank, lights].
pub(crate) fn weighted_lights(basis: &Basis, ensemble: &Ensemble) -> ndarray::Array2<f64> {
    let (rank, lights) = (basis.rank, ensemble.lights);
    let rows: Vec<Vec<f64>> = (0..rank)
        .into_par_iter()
        .map(|k| {
            let read = &basis.read[k * basis.columns..(k + 1) * basis.columns];
            let mut sum = vec![0.0f64; lights];
            for (read, e) in read
                .iter()
                .zip(ensemble.irradiance.chunks_exact(lights.max(1)))
            {
                if *read != 0.0 {
                    let terms = sum.iter_mut().zip(e);
                    terms.for_each(|(s, &e)| *s += f64::from(*read) * f64::from(e));
                }
            }
            sum
        })
        .collect();
    ndarray::Array2::from_shape_fn((rank, lights), |(k, l)| rows[k][l] * basis.lights[l])
}
