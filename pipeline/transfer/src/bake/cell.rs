//! One cell: its directions, and what answers for its rows.

use super::config::{CellChoice, TransferConfig};
use crate::TransferError;
use crate::basis::CellBasis;
use crate::model::{PartFit, TransferCell, TransferNet, TransferNodes};
use crate::query::{INPUTS, VIEW};
use crate::reflectance::Reflectances;
use crate::regression::{Combination, LocalFits, LocalScratch, RowTable, Samples, fit_net};
use crate::tracing::Stream;
use glam::Vec3;
use ndarray::{Array1, Array2};

/// What all cells are fitted by.
pub(crate) struct CellFitter<'a> {
    pub(crate) table: &'a RowTable,
    pub(crate) fits: &'a LocalFits<'a>,
    pub(crate) reflectances: &'a Reflectances,
    /// Which materials are metals: all of their light depends on the viewer.
    pub(crate) metals: &'a [bool],
    /// Weighted coefficients of the ensemble's lights, shape [rank, lights].
    pub(crate) lights: &'a Array2<f64>,
    pub(crate) config: &'a TransferConfig,
}

/// Spread below which an input says nothing.
const SPREAD: f32 = 1e-4;

/// A cell's rows, smoothed by local fits.
struct Smoothed {
    /// Fits of both parts at each row.
    combinations: Vec<[Option<Combination>; 2]>,
    /// Both halves of each row, shape [2 parts, rank, 3].
    halves: [Vec<Vec<f32>>; 2],
}

impl CellFitter<'_> {
    /// Fits the cell of these rows.
    pub(crate) fn fit(
        &self,
        rows: &[u32],
        stream: Stream,
    ) -> Result<[TransferCell; 2], TransferError> {
        let smoothed = self.smooth(rows);
        let basis = self.directions(rows, &smoothed, stream)?;
        let targets = self.targets(&smoothed, &basis);
        let part = |k: usize, fit: &dyn Fn(usize) -> Option<PartFit>| {
            let has = self.reflectances.has(self.material(rows), k);
            has.then(|| fit(k)).flatten().unwrap_or_default()
        };
        let nets = |k: usize| {
            self.net(rows, &targets[k], &basis, k, stream)
                .map(PartFit::Net)
        };
        let nodes = |k: usize| {
            Some(PartFit::Nodes(
                self.nodes(rows, &smoothed, &basis, k, stream),
            ))
        };
        let cell = |parts: [PartFit; 2]| TransferCell {
            basis: basis.clone(),
            parts,
            error: f32::INFINITY,
            trusted: false,
        };
        let net = match self.config.choice {
            CellChoice::Nodes => Default::default(),
            _ => [part(0, &nets), part(1, &nets)],
        };
        let node = match self.config.choice {
            CellChoice::Nets => Default::default(),
            _ => [part(0, &nodes), part(1, &nodes)],
        };
        Ok([cell(net), cell(node)])
    }

    fn material(&self, rows: &[u32]) -> u32 {
        rows.first()
            .map_or(0, |&row| self.table.queries[row as usize].surface.material)
    }

    /// Whether a part of a material depends on the viewer beyond its albedo.
    fn sees_viewer(&self, material: u32, part: usize) -> bool {
        part == 1 || self.metals.get(material as usize).copied().unwrap_or(false)
    }

    fn smooth(&self, rows: &[u32]) -> Smoothed {
        let mut scratch = LocalScratch::default();
        let material = self.material(rows);
        let mut smoothed = Smoothed {
            combinations: Vec::with_capacity(rows.len()),
            halves: Default::default(),
        };
        for &row in rows {
            let query = &self.table.queries[row as usize];
            let own = [0, 1].map(|part| {
                let has = self.reflectances.has(material, part);
                let view = self.sees_viewer(material, part);
                has.then(|| self.fits.at(query, view, None, &mut scratch))
                    .flatten()
            });
            for (half, all) in smoothed.halves.iter_mut().enumerate() {
                let parts = own.iter().enumerate().map(|(part, fit)| match fit {
                    Some(fit) => fit.apply(self.table, half, part, 0),
                    None => vec![0.0; self.table.stride()],
                });
                all.push(parts.flatten().collect());
            }
            smoothed.combinations.push(own);
        }
        smoothed
    }

    /// What a row's parts count for in its radiance, relative to what it gets.
    fn shares(&self, row: u32) -> [Vec3; 2] {
        let query = &self.table.queries[row as usize];
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
    ) -> Result<CellBasis, TransferError> {
        let rank = self.table.rank;
        let shares: Vec<[Vec3; 2]> = rows.iter().map(|&row| self.shares(row)).collect();
        let [first, second] = [0, 1].map(|half| {
            Array2::from_shape_fn((3 * rows.len(), rank), |(r, k)| {
                let (row, channel) = (r / 3, r % 3);
                let values = &smoothed.halves[half][row];
                let part =
                    |p: usize| values[3 * (p * rank + k) + channel] * shares[row][p][channel];
                f64::from(part(0) + part(1))
            })
        });
        let (target, most) = (self.config.cell_error, self.config.cell_rank);
        CellBasis::new([&first, &second], self.lights, target, most, stream.part(0))
    }

    /// Both parts of every smoothed row in the cell's directions, shape [rows, 3 directions].
    fn targets(&self, smoothed: &Smoothed, basis: &CellBasis) -> [Array2<f64>; 2] {
        let stride = self.table.stride();
        let mean = |row: usize, part: usize| -> Vec<f32> {
            let own = part * stride..(part + 1) * stride;
            let [a, b] = [0, 1].map(|half| &smoothed.halves[half][row][own.clone()]);
            a.iter().zip(b).map(|(a, b)| 0.5 * (a + b)).collect()
        };
        [0, 1].map(|part| {
            let rows = smoothed.combinations.len();
            let mut all = Array2::zeros((rows, 3 * basis.rank));
            for (row, mut out) in all.rows_mut().into_iter().enumerate() {
                let made = made(&mean(row, part), basis);
                out.iter_mut()
                    .zip(made)
                    .for_each(|(o, x)| *o = f64::from(x));
            }
            all
        })
    }

    fn net(
        &self,
        rows: &[u32],
        targets: &Array2<f64>,
        basis: &CellBasis,
        part: usize,
        stream: Stream,
    ) -> Option<TransferNet> {
        let all: Vec<[f32; INPUTS]> = (rows.iter())
            .map(|&row| self.table.queries[row as usize].inputs())
            .collect();
        let seen = if self.sees_viewer(self.material(rows), part) {
            INPUTS
        } else {
            VIEW
        };
        let spread = |j: usize| {
            let (low, high) = all
                .iter()
                .fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), x| {
                    (l.min(x[j]), h.max(x[j]))
                });
            high - low > SPREAD
        };
        let inputs: Vec<u8> = (0..seen).filter(|&j| spread(j)).map(|j| j as u8).collect();
        if inputs.is_empty() {
            return None;
        }
        let strength = |k: usize| {
            let read = &basis.read[k * self.table.rank..(k + 1) * self.table.rank];
            let lights = self.lights.columns().into_iter();
            let squares = lights.map(|light| {
                let c: f64 = read.iter().zip(light).map(|(r, l)| f64::from(*r) * l).sum();
                c * c
            });
            (squares.sum::<f64>() / self.lights.ncols().max(1) as f64).sqrt()
        };
        let strengths: Vec<f64> = (0..basis.rank).map(strength).collect();
        let samples = Samples {
            x: Array2::from_shape_fn((rows.len(), inputs.len()), |(i, j)| {
                f64::from(all[i][inputs[j] as usize])
            }),
            inputs,
            y: targets.clone(),
            weights: Array1::from_shape_fn(rows.len(), |i| {
                f64::from(self.shares(rows[i])[part].element_sum() / 3.0)
            }),
            scales: Array1::from_shape_fn(3 * basis.rank, |k| strengths[k / 3].max(1e-12)),
        };
        fit_net(&samples, &self.config.net, stream.part(1 + part as u32))
    }

    /// Local fits at some of the rows' own points.
    fn nodes(
        &self,
        rows: &[u32],
        smoothed: &Smoothed,
        basis: &CellBasis,
        part: usize,
        stream: Stream,
    ) -> TransferNodes {
        let numbers = stream.part(3);
        let mut order: Vec<usize> = (0..rows.len()).collect();
        order.sort_by_key(|&i| (numbers.block(i as u64, 0, 0)[0], i));
        order.truncate(self.config.nodes.max(1));
        order.sort_unstable();
        let view = self.sees_viewer(self.material(rows), part);
        let mut nodes = TransferNodes {
            turns: [
                self.config.local.turn,
                if view { self.config.local.view } else { 0.0 },
            ],
            ..TransferNodes::default()
        };
        for i in order {
            let Some(fit) = &smoothed.combinations[i][part] else {
                continue;
            };
            let query = &self.table.queries[rows[i] as usize];
            nodes.places.extend(query.inputs());
            nodes.normals.extend(query.geometric.to_array());
            for which in 0..3 {
                let [a, b] = [0, 1].map(|half| fit.apply(self.table, half, part, which));
                let mean: Vec<f32> = a.iter().zip(b).map(|(a, b)| 0.5 * (a + b)).collect();
                nodes.values.extend(made(&mean, basis));
            }
        }
        nodes
    }
}

/// A projected row, shape [rank, 3], in a cell's directions.
fn made(row: &[f32], basis: &CellBasis) -> Vec<f32> {
    let mut out = vec![0.0f32; 3 * basis.rank];
    for (values, make) in row.chunks_exact(3).zip(basis.make.chunks_exact(basis.rank)) {
        for (out, &m) in out.chunks_exact_mut(3).zip(make) {
            for (o, v) in out.iter_mut().zip(values) {
                *o += v * m;
            }
        }
    }
    out
}
