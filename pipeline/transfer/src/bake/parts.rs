//! Fits of a cell's two parts.

use super::cell::CellFitter;
use super::part_rows::PartRows;
use crate::model::{PartFit, TransferNodes};
use crate::query::{INPUTS, VIEW};
use crate::regression::{NetConfig, Samples, fit_net};
use crate::tracing::Stream;
use ndarray::{Array1, Array2};

/// Spread below which an input says nothing.
const SPREAD: f32 = 1e-4;
/// Rows that a hidden unit asks for, and units that a net has all the same.
const ROWS_A_UNIT: usize = 10;
const LEAST_UNITS: usize = 2;

impl CellFitter<'_> {
    /// A net and its exact outputs; none where no input says anything.
    pub(super) fn net(&self, of: &PartRows, stream: Stream) -> Option<(PartFit, Vec<f32>)> {
        let &PartRows {
            rows,
            smoothed,
            directions,
            part,
            view,
        } = of;
        let queries = rows
            .iter()
            .map(|&row| &self.batch.table.queries[row as usize]);
        let all: Vec<[f32; INPUTS]> = queries.map(|query| query.inputs()).collect();
        let spread = |j: usize| {
            let start = (f32::INFINITY, f32::NEG_INFINITY);
            let (low, high) = all
                .iter()
                .fold(start, |(l, h), x| (l.min(x[j]), h.max(x[j])));
            high - low > SPREAD
        };
        let seen = if view { INPUTS } else { VIEW };
        let inputs: Vec<u8> = (0..seen).filter(|&j| spread(j)).map(|j| j as u8).collect();
        if inputs.is_empty() {
            return None;
        }
        let count = (self.batch.table.lights as f64).sqrt();
        let made: Vec<Vec<f32>> = (0..rows.len())
            .map(|i| directions.made(smoothed.part(i, part)))
            .collect();
        let samples = Samples {
            x: Array2::from_shape_fn((rows.len(), inputs.len()), |(i, j)| {
                f64::from(all[i][inputs[j] as usize])
            }),
            inputs,
            y: Array2::from_shape_fn((rows.len(), 3 * directions.rank), |(i, k)| {
                f64::from(made[i][k])
            }),
            weights: Array1::from_shape_fn(rows.len(), |i| {
                f64::from(self.shares(rows[i])[part].element_sum() / 3.0)
            }),
            scales: Array1::from_shape_fn(3 * directions.rank, |k| {
                (directions.values[k / 3] / count).max(1e-12)
            }),
        };
        let most = (rows.len() / ROWS_A_UNIT).max(LEAST_UNITS);
        let config = NetConfig {
            units: self.config.net.units.min(most),
            ..self.config.net
        };
        let (net, output) = fit_net(&samples, &config, stream.part(1 + part as u32))?;
        Some((PartFit::Net(net), output))
    }

    /// Local fits at some of the rows' own points, and their exact values.
    pub(super) fn nodes(&self, of: &PartRows, stream: Stream) -> (PartFit, Vec<f32>) {
        let &PartRows {
            rows,
            smoothed,
            directions,
            part,
            view,
        } = of;
        let table = &self.batch.table;
        let numbers = stream.part(3);
        let mut order: Vec<usize> = (0..rows.len()).collect();
        order.sort_by_key(|&i| (numbers.block(i as u64, 0, 0)[0], i));
        order.truncate(self.config.nodes.max(1));
        order.sort_unstable();
        let local = &self.config.local;
        let mut values = Vec::new();
        let mut nodes = TransferNodes {
            turns: [local.turn, if view { local.view } else { 0.0 }],
            ..TransferNodes::default()
        };
        for i in order {
            let Some(fit) = &smoothed.combinations[i][part] else {
                continue;
            };
            let query = &table.queries[rows[i] as usize];
            nodes.places.extend(query.inputs());
            nodes.normals.extend(query.geometric.to_array());
            for which in 0..3 {
                values.extend(directions.made(&fit.apply(table, part, which)));
            }
        }
        (PartFit::Nodes(nodes), values)
    }
}
