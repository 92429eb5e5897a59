//! The cells of a batch of surfaces, with more rows where they err.

use super::batch::{Batch, BatchTracer};
use super::cell::CellFitter;
use super::draw::near;
use super::memory::MemoryNeed;
use super::sketch::{Sketch, SketchRow};
use super::tree::cut;
use super::watch::TransferWatch;
use crate::TransferError;
use crate::columns::ColumnTree;
use crate::model::{SurfaceCells, TransferCell};
use crate::query::SurfaceKey;
use crate::regression::{LocalFits, Surroundings};
use crate::rows::RowPoint;
use crate::tracing::Stream;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Streams of a bake that rounds draw from.
#[derive(Clone, Copy)]
pub(crate) struct RoundStreams {
    /// Paths of rows.
    pub(crate) rows: Stream,
    /// Fits of cells.
    pub(crate) fits: Stream,
    /// Places of further rows.
    pub(crate) more: Stream,
    /// Signs of rows in sketches.
    pub(crate) sketch: Stream,
}

/// All that rounds need beside the points.
pub(crate) struct Rounds<'a> {
    pub(crate) tracer: BatchTracer<'a>,
    pub(crate) metals: &'a [bool],
    pub(crate) columns: &'a ColumnTree,
    pub(crate) streams: RoundStreams,
    pub(crate) memory: MemoryNeed,
}

/// One surface's cells.
#[derive(Default)]
pub(crate) struct SurfaceFit {
    pub(crate) tree: SurfaceCells,
    pub(crate) cells: Vec<TransferCell>,
    /// Rows of each cell, and what surrounds them.
    rows: Vec<Vec<(u32, Surroundings)>>,
    /// Some of them, smoothed.
    picked: Vec<SketchRow>,
}

/// Further rows of a cell in a round, as a share of those it has.
const GROWTH: f32 = 1.5;
/// Rows that a cell gets before its error is believed.
const FEW: usize = 96;
/// Weight of even light beside steep light.
const EVEN: f32 = 0.1;

impl Rounds<'_> {
    /// Fits the surfaces of some points. Rows draw at indices from `first` on, which this moves.
    pub(crate) fn fit(
        &self,
        mut points: Vec<RowPoint>,
        first: &mut u64,
        sketch: &mut Sketch,
        watch: &dyn TransferWatch,
    ) -> Result<BTreeMap<SurfaceKey, SurfaceFit>, TransferError> {
        let config = self.tracer.config;
        let mut batch = self.trace(&points, first)?;
        let mut found: BTreeMap<SurfaceKey, SurfaceFit> = BTreeMap::new();
        let mut todo: Vec<SurfaceKey> = batch.table.queries.iter().map(|q| q.surface).collect();
        todo.sort_unstable();
        todo.dedup();
        for round in 0..=config.rounds {
            if watch.halted() {
                return Err(TransferError::Halted);
            }
            for (key, fit) in self.cells(&batch, &todo, watch)? {
                found.insert(key, fit);
            }
            if round == config.rounds || !watch.may_refine() {
                break;
            }
            let mut more = Vec::new();
            todo.retain(|key| {
                let before = more.len();
                if let Some(fit) = found.get(key) {
                    self.more(fit, &points, round, &mut more);
                }
                more.len() > before
            });
            if more.is_empty() || !self.memory.allows(points.len() + more.len()) {
                break;
            }
            batch.append(self.trace(&more, first)?);
            points.extend(more);
        }
        for fit in found.values() {
            let reflectances = self.tracer.reflectances;
            sketch.add(&batch, &fit.picked, reflectances, self.streams.sketch);
        }
        Ok(found)
    }

    fn trace(&self, points: &[RowPoint], first: &mut u64) -> Result<Batch, TransferError> {
        let batch = self.tracer.trace(points, self.streams.rows, *first);
        *first += points.len() as u64;
        batch
    }

    /// Places of further rows: around those of cells that err too much, above all where light
    /// falls steeply.
    fn more(&self, fit: &SurfaceFit, points: &[RowPoint], round: u32, more: &mut Vec<RowPoint>) {
        let config = self.tracer.config;
        for (cell, rows) in fit.cells.iter().zip(&fit.rows) {
            let over = (cell.error / config.target).powi(2) - 1.0;
            let steep = |around: &Surroundings| EVEN + around.steepness.powi(2);
            let total: f32 = rows.iter().map(|row| steep(&row.1)).sum();
            if over <= 0.0 || total <= 0.0 {
                continue;
            }
            let lacking = FEW.saturating_sub(rows.len()) as f32;
            let count = (over.min(GROWTH) * rows.len() as f32).max(lacking);
            let mut due = 0.5;
            for (row, around) in rows {
                due += count * steep(around) / total;
                for k in 0..due as u32 {
                    let numbers = |t: u32| {
                        let part = self.streams.more.part(t);
                        part.units(u64::from(*row), k, round)
                    };
                    let like = &points[*row as usize];
                    more.extend(near(self.tracer.tracer, like, around.radius, &numbers));
                }
                due = due.fract();
            }
        }
    }

    /// Cuts surfaces into cells and fits each.
    fn cells(
        &self,
        batch: &Batch,
        surfaces: &[SurfaceKey],
        watch: &dyn TransferWatch,
    ) -> Result<Vec<(SurfaceKey, SurfaceFit)>, TransferError> {
        let table = &batch.table;
        let config = self.tracer.config;
        let judging: Vec<bool> = table.judged.iter().map(|j| !j.is_empty()).collect();
        let fits = LocalFits::new(table, config.local, &judging, &|| watch.halted());
        if watch.halted() {
            return Err(TransferError::Halted);
        }
        let mut rows: BTreeMap<SurfaceKey, [Vec<u32>; 2]> = BTreeMap::new();
        for (row, query) in table.queries.iter().enumerate() {
            let own = rows.entry(query.surface).or_default();
            own[usize::from(judging[row])].push(row as u32);
        }
        let fitter = CellFitter {
            batch,
            fits: &fits,
            reflectances: self.tracer.reflectances,
            metals: self.metals,
            lighting: self.tracer.lighting,
            columns: self.columns,
            sketch_signs: self.streams.sketch,
            config,
        };
        let mut cut_surfaces = Vec::new();
        let mut cells: Vec<(usize, Vec<u32>, Vec<u32>)> = Vec::new();
        for &key in surfaces {
            let Some([training, judges]) = rows.remove(&key) else {
                continue;
            };
            let mut fit = SurfaceFit::default();
            let parts = cut(
                &mut fit.tree,
                table,
                &fits.weights,
                training,
                config.cell_rows,
            );
            let first = cells.len();
            let surface = cut_surfaces.len();
            cells.extend(parts.into_iter().map(|rows| (surface, rows, Vec::new())));
            for row in judges {
                if let Some(cell) = fit.tree.find(&table.queries[row as usize]) {
                    cells[first + cell as usize].2.push(row);
                }
            }
            cut_surfaces.push((key, fit));
        }
        let fitted: Vec<Result<_, TransferError>> = (cells.par_iter())
            .map(|(_, rows, judges)| {
                if watch.halted() {
                    return Err(TransferError::Halted);
                }
                let name = rows.first().copied().unwrap_or(0);
                fitter.fit(rows, judges, self.streams.fits.part(name))
            })
            .collect();
        for ((surface, rows, _), cell) in cells.into_iter().zip(fitted) {
            let fit = &mut cut_surfaces[surface].1;
            let (cell, picked) = cell?;
            fit.cells.push(cell);
            fit.picked.extend(picked);
            let around = |row: u32| (row, fits.surroundings[row as usize]);
            fit.rows.push(rows.into_iter().map(around).collect());
        }
        Ok(cut_surfaces)
    }
}
