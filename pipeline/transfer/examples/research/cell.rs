//! Cells: the directions that their rows need, and nets with many linear outputs.

use crate::net::{Net, Samples, Settings};
use crate::regress::Plan;
use crate::table::Row;
use glam::Vec3;
use ndarray::{Array1, Array2, s};
use rrf_sampling::{Stage, Stream};
use rrf_transfer::{CellBasis, Entry};

/// A cell: its directions and two nets, of the base part and of the constant one.
pub struct Cell {
    pub basis: CellBasis,
    pub nets: [Net; 2],
}

impl Cell {
    pub fn new(
        plan: &Plan,
        table: &[Row],
        projected: &[[Vec<Entry>; 2]],
        of: &[usize],
        lights: &Array2<f64>,
        stream: Stream,
    ) -> Cell {
        let rank = lights.nrows();
        let row = |i: usize| &table[of[i]];
        let weighted = |h: usize| {
            Array2::from_shape_fn((3 * of.len(), rank), |(r, k)| {
                let value = projected[of[r / 3]][h][k].coloured(row(r / 3).colour)[r % 3];
                f64::from(value * row(r / 3).weight)
            })
        };
        let halves = [weighted(0), weighted(1)];
        let target = 0.01;
        let basis = CellBasis::new(
            [&halves[0], &halves[1]],
            lights,
            target,
            plan.cell_rank,
            stream,
        )
        .expect("a basis");
        let made = |h: usize, r: usize, part: usize| -> Vec<Vec3> {
            let entries = &projected[of[r]][h];
            (0..basis.rank)
                .map(|k| {
                    let terms = entries.iter().enumerate().map(|(d, e)| {
                        let value = if part == 0 { e.base } else { e.constant };
                        value * basis.make[d * basis.rank + k]
                    });
                    terms.sum()
                })
                .collect()
        };
        let read = Array2::from_shape_fn((basis.rank, rank), |(k, d)| {
            f64::from(basis.read[k * rank + d])
        });
        let strength = read.dot(lights);
        let strength: Vec<f64> = (strength.rows().into_iter())
            .map(|r| (r.iter().map(|x| x * x).sum::<f64>() / r.len() as f64).sqrt())
            .collect();
        let nets = [0, 1].map(|part| {
            let targets = [0, 1].map(|h| {
                let flat: Vec<f64> = (0..of.len())
                    .flat_map(|r| made(h, r, part))
                    .flat_map(|v| v.to_array())
                    .map(f64::from)
                    .collect();
                Array2::from_shape_vec((of.len(), 3 * basis.rank), flat).expect("shape")
            });
            let inputs: Vec<f64> = (0..of.len()).flat_map(|i| inputs(row(i), part)).collect();
            let width = inputs.len() / of.len();
            let colour = |i: usize| {
                if part == 0 {
                    row(i).colour.element_sum() / 3.0
                } else {
                    1.0
                }
            };
            let samples = shuffled(Samples {
                inputs: Array2::from_shape_vec((of.len(), width), inputs).expect("shape"),
                halves: targets,
                weights: Array1::from_shape_fn(of.len(), |i| f64::from(row(i).weight * colour(i))),
                scales: Array1::from_shape_fn(3 * basis.rank, |k| strength[k / 3]),
                training: of.len() - of.len() / 6,
            });
            let settings = Settings {
                hidden: if part == 0 {
                    plan.hidden
                } else {
                    plan.hidden / 2
                },
                ridge: plan.ridge,
                decay: plan.decay,
                iterations: 60,
            };
            Net::fit(&samples, &settings, stream.part(part as u32))
        });
        Cell { basis, nets }
    }

    /// Radiance under lights given by their coefficients in the basis.
    pub fn predict(&self, row: &Row, lights: &[Vec<Vec3>]) -> Vec<Vec3> {
        let [base, constant] = [0, 1].map(|part| self.nets[part].evaluate(&inputs(row, part)));
        let of = |values: &[f64], k: usize| {
            Vec3::new(
                values[3 * k] as f32,
                values[3 * k + 1] as f32,
                values[3 * k + 2] as f32,
            )
        };
        (lights.iter())
            .map(|light| {
                let c = self.basis.coefficients(light);
                let sum: Vec3 = (0..self.basis.rank)
                    .map(|k| (of(&constant, k) + row.colour * of(&base, k)) * c[k])
                    .sum();
                sum.max(Vec3::ZERO)
            })
            .collect()
    }
}

/// What a net sees: place and normal, and for what depends on the viewer, the viewer.
fn inputs(row: &Row, part: usize) -> Vec<f64> {
    let mut x = row.position.to_array().to_vec();
    x.extend(row.normal.to_array());
    let facing = row.normal.dot(row.viewer);
    if part == 1 || row.metal {
        x.extend(row.reflected.to_array());
    }
    x.extend([facing, (1.0 - facing).powi(5)]);
    x.into_iter().map(f64::from).collect()
}

/// TransferRows in an order that has nothing to do with where they lie.
fn shuffled(samples: Samples) -> Samples {
    let n = samples.inputs.nrows();
    let stream = Stream::new(9, Stage::Test, 907);
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by_key(|&i| stream.block(i as u64, 0, 0)[0]);
    let pick = |m: &Array2<f64>| Array2::from_shape_fn(m.dim(), |(i, j)| m[[order[i], j]]);
    Samples {
        inputs: pick(&samples.inputs),
        halves: [pick(&samples.halves[0]), pick(&samples.halves[1])],
        weights: Array1::from_shape_fn(n, |i| samples.weights[order[i]]),
        scales: samples.scales.slice(s![..]).to_owned(),
        training: samples.training,
    }
}
