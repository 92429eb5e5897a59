//! One cell: its directions, and what answers for its rows.

use super::batch::{Batch, scales};
use super::compress::{DenseRead, clustered};
use super::config::{CellChoice, TransferConfig};
use super::directions::Directions;
use super::exact::ExactParts;
use super::judge::{Judged, borne_out, judged_error};
use super::lighting::Lighting;
use super::part_rows::PartRows;
use super::sketch::{SketchRow, sign};
use super::smooth::Smoothed;
use crate::TransferError;
use crate::columns::ColumnTree;
use crate::model::{PackedRows, PartFit, SKETCHES, TransferCell};
use crate::reflectance::Reflectances;
use crate::regression::LocalFits;
use crate::svd::leading;
use crate::tracing::Stream;
use glam::Vec3;
use ndarray::Array2;

/// Data and settings that all cells are fitted by.
pub(crate) struct CellFitter<'a> {
    pub(crate) batch: &'a Batch,
    pub(crate) fits: &'a LocalFits<'a>,
    pub(crate) reflectances: &'a Reflectances,
    /// Which materials are metals: all of their light depends on the viewer.
    pub(crate) metals: &'a [bool],
    pub(crate) lighting: &'a Lighting,
    pub(crate) columns: &'a ColumnTree,
    pub(crate) sketch_signs: Stream,
    pub(crate) config: &'a TransferConfig,
}

/// Rows below which no net is fitted.
const LEAST_ROWS: usize = 24;
/// Nodes of the column tree that a cell reads at most.
const MOST_NODES: usize = 1_024;
/// Rows of a cell that sketches take.
const SKETCH_ROWS: usize = 6;

impl CellFitter<'_> {
    /// Fits the cell of these rows; `judges` are rows of the cell that it must not see.
    pub(crate) fn fit(
        &self,
        rows: &[u32],
        judges: &[u32],
        stream: Stream,
    ) -> Result<(TransferCell, Vec<SketchRow>), TransferError> {
        let material = rows.first().map_or(0, |&row| self.material(row));
        let has = [0, 1].map(|part| self.reflectances.has(material, part));
        let view = [0, 1].map(|part| self.sees_viewer(material, part));
        let smoothed = Smoothed::new(&self.batch.table, self.fits, rows, has, view);
        let directions = self.directions(rows, &smoothed, stream.part(0))?;
        let dense = self.dense_read(rows, &smoothed, &directions);
        let lights = dense.judging(self.lighting);
        let judge_shares: Vec<[Vec3; 2]> = judges.iter().map(|&row| self.shares(row)).collect();
        let mut best: Option<(Judged, ExactParts, [Vec<f32>; 2])> = None;
        for is_net in [true, false] {
            let skip = match self.config.choice {
                CellChoice::Best => false,
                CellChoice::Nets => !is_net && rows.len() >= LEAST_ROWS,
                CellChoice::Nodes => is_net,
            };
            if skip || is_net && rows.len() < LEAST_ROWS {
                continue;
            }
            let part = |part: usize| {
                let of = PartRows {
                    rows,
                    smoothed: &smoothed,
                    directions: &directions,
                    part,
                    view: view[part],
                };
                match (has[part], is_net) {
                    (false, _) => Some((PartFit::Nothing, Vec::new())),
                    (true, true) => self.net(&of, stream),
                    (true, false) => Some(self.nodes(&of, stream)),
                }
            };
            let (Some(base), Some(constant)) = (part(0), part(1)) else {
                continue;
            };
            let mut parts = ExactParts::new([base, constant], directions.rank);
            let table = &self.batch.table;
            let borne = borne_out(&parts.fits, table, judges, &judge_shares, &directions);
            parts.scale(&borne);
            let judged = self.judged(&parts.fits, judges, &lights);
            // a net stands unless local fits are clearly better
            let patience = self.config.patience;
            let beaten = |(of, ..): &(Judged, _, _)| judged.beats(of, patience);
            if best.as_ref().is_none_or(beaten) {
                best = Some((judged, parts, borne));
            }
        }
        let Some((judged, mut parts, borne)) = best else {
            let picked = self.sketch(rows, &smoothed, &directions).0;
            let none = TransferCell {
                error: f32::INFINITY,
                ..TransferCell::default()
            };
            return Ok((none, picked));
        };
        // what is left out may add a share of the error that the cell has anyway
        let allowed = self.config.left_out(judged.stated());
        let kept = directions.needed(&borne, allowed);
        parts.keep(&kept);
        let (directions, dense) = (directions.only(&kept), dense.only(&kept));
        let (columns, lighting) = (self.columns, self.lighting);
        let read = clustered(
            &dense,
            columns,
            lighting,
            allowed,
            MOST_NODES,
            stream.part(4),
        );
        let lights: Vec<Vec<Vec3>> = (lighting.judges_on_nodes.iter())
            .map(|fluxes| read.coefficients(fluxes))
            .collect();
        let (picked, sketch) = self.sketch(rows, &smoothed, &directions);
        let cell = TransferCell {
            error: self.judged(&parts.fits, judges, &lights).stated(),
            parts: parts.fits,
            rows: rows.len() as u32,
            judged: judges.len() as u32,
            sketch: PackedRows::pack(&sketch, directions.rank),
            read,
        };
        Ok((cell, picked))
    }

    fn judged(&self, parts: &[PartFit; 2], judges: &[u32], lights: &[Vec<Vec3>]) -> Judged {
        judged_error(parts, self.batch, judges, lights, self.reflectances)
    }

    fn material(&self, row: u32) -> u32 {
        self.batch.table.queries[row as usize].surface.material
    }

    /// Whether a part of a material depends on the viewer beyond its albedo.
    fn sees_viewer(&self, material: u32, part: usize) -> bool {
        part == 1 || self.metals.get(material as usize).copied().unwrap_or(false)
    }

    /// Weights of a row's parts in its radiance, relative to what it gets.
    pub(super) fn shares(&self, row: u32) -> [Vec3; 2] {
        let query = &self.batch.table.queries[row as usize];
        let weight = self.fits.weights[row as usize];
        let [base, constant] = (self.reflectances).at(query.surface.material, query.facing());
        [
            query.base_color * (base * weight),
            Vec3::splat(constant * weight),
        ]
    }

    /// The directions that the smoothed rows need.
    fn directions(
        &self,
        rows: &[u32],
        smoothed: &Smoothed,
        stream: Stream,
    ) -> Result<Directions, TransferError> {
        let lights = self.batch.table.lights;
        let shares: Vec<[Vec3; 2]> = rows.iter().map(|&row| self.shares(row)).collect();
        let matrix = Array2::from_shape_fn((3 * rows.len(), lights), |(r, l)| {
            let (row, channel) = (r / 3, r % 3);
            let part =
                |p: usize| smoothed.part(row, p)[channel * lights + l] * shares[row][p][channel];
            f64::from(part(0) + part(1))
        });
        let most = self.config.cell_rank.min(lights).max(1);
        let found = leading(&matrix, most, stream)?;
        let whole: f64 = matrix.iter().map(|x| x * x).sum();
        let allowed = self.config.cell_error.powi(2) * whole;
        let mut rest = whole;
        let mut rank = 0;
        while rank < found.values.len() && (rest > allowed || rank == 0) {
            if found.values[rank] <= 0.0 && rank > 0 {
                break;
            }
            rest -= found.values[rank].powi(2);
            rank += 1;
        }
        Ok(Directions {
            rank,
            left: found.left.slice(ndarray::s![.., ..rank]).to_owned(),
            values: found.values.slice(ndarray::s![..rank]).to_owned(),
            right: found.right.slice(ndarray::s![..rank, ..]).to_owned(),
        })
    }

    /// Contribution of one unit of irradiance on a column to each direction: the rows' own columns.
    fn dense_read(&self, rows: &[u32], smoothed: &Smoothed, directions: &Directions) -> DenseRead {
        let rank = directions.rank;
        let table = &self.batch.table;
        // factors of raw rows: [row][part][channel][rank]
        let mut factors: std::collections::BTreeMap<u32, Vec<f32>> = Default::default();
        for (i, &row) in rows.iter().enumerate() {
            let shares = self.shares(row);
            for (part, fit) in smoothed.combinations[i].iter().enumerate() {
                let Some(fit) = fit else { continue };
                for (&raw, &factor) in fit.rows.iter().zip(&fit.factors[0]) {
                    let own = factors.entry(raw).or_insert_with(|| vec![0.0; 6 * rank]);
                    for (channel, share) in shares[part].to_array().into_iter().enumerate() {
                        let by = factor * share;
                        let left = directions.left.row(3 * i + channel);
                        let first = (3 * part + channel) * rank;
                        for (f, &u) in own[first..first + rank].iter_mut().zip(left) {
                            *f += by * u as f32;
                        }
                    }
                }
            }
        }
        let mut weights = vec![0.0f32; self.columns.columns() * rank];
        for (raw, factors) in factors {
            let row = raw as usize;
            let scale = scales(self.reflectances, &table.queries[row]);
            for half in 0..2 {
                let (columns, entries) = self.batch.sparse.half(row, half);
                for (&column, entry) in columns.iter().zip(entries) {
                    let first = column as usize * rank;
                    let out = &mut weights[first..first + rank];
                    let values = [
                        entry.base * (0.5 * scale[0]),
                        entry.constant * (0.5 * scale[1]),
                    ];
                    let values = values.iter().flat_map(Vec3::to_array);
                    for (value, factors) in values.zip(factors.chunks_exact(rank)) {
                        if value != 0.0 {
                            out.iter_mut()
                                .zip(factors)
                                .for_each(|(o, f)| *o += value * f);
                        }
                    }
                }
            }
        }
        DenseRead { rank, weights }
    }

    /// Some of the smoothed rows, and the cell's own part of their random combinations, shape
    /// [sketches, rank].
    fn sketch(
        &self,
        rows: &[u32],
        smoothed: &Smoothed,
        directions: &Directions,
    ) -> (Vec<SketchRow>, Vec<f32>) {
        let step = rows.len().div_ceil(SKETCH_ROWS).max(1);
        // each stands for the rows that it is picked from
        let by = (step as f32).sqrt();
        let mut sums = vec![0.0f32; SKETCHES * directions.rank];
        let mut picked = Vec::new();
        for i in (0..rows.len()).step_by(step) {
            let row = rows[i];
            let shares = self.shares(row).map(|share| share * by);
            let made = [0, 1].map(|part| directions.made(smoothed.part(i, part)));
            let mean: Vec<f32> = (0..directions.rank)
                .map(|k| {
                    let part = |p: usize| Vec3::from_slice(&made[p][3 * k..]).dot(shares[p]);
                    (part(0) + part(1)) / 3.0
                })
                .collect();
            for (sketch, out) in sums.chunks_exact_mut(directions.rank).enumerate() {
                let by = sign(self.sketch_signs, row, sketch);
                out.iter_mut().zip(&mean).for_each(|(o, m)| *o += by * m);
            }
            picked.push(SketchRow {
                row,
                shares,
                parts: smoothed.combinations[i].clone(),
            });
        }
        (picked, sums)
    }
}
