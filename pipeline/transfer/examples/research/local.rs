//! Local fits over rows elsewhere: the simplest regression.

use crate::table::Table;
use crate::truth::Truth;
use glam::Vec3;
use ndarray::{Array1, Array2, s};
use ndarray_linalg::{FactorizeC, SolveC, UPLO};
use rrf_transfer::Entry;

/// How a local fit is made.
#[derive(Clone, Copy)]
pub struct Local {
    pub neighbours: usize,
    /// 0 constant, 1 linear, 2 quadratic in the tangent plane.
    pub order: usize,
    /// Whether errors count relative to what a row gets.
    pub relative: bool,
}

/// Radiance of every point under every light of the truth.
pub fn predict(table: &Table, truth: &Truth, values: &[Vec<Entry>], local: &Local) -> Vec<Vec3> {
    let lights = truth.lights.len();
    let mut all = Vec::with_capacity(truth.weights.len());
    for at in 0..truth.points.len() {
        let own = &table.judged[at];
        let mut near: Vec<(f32, usize)> = (0..table.rows.len())
            .filter(|&i| table.rows[i].alike(own))
            .map(|i| (table.rows[i].distance(own), i))
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        near.truncate(local.neighbours);
        let weights = fit(table, own, &near, local);
        all.extend((0..lights).map(|light| {
            let mut sum = Entry::default();
            for (&(_, i), &w) in near.iter().zip(&weights) {
                sum.base += values[i][light].base * w;
                sum.constant += values[i][light].constant * w;
            }
            sum.coloured(own.colour).max(Vec3::ZERO)
        }));
    }
    all
}

/// What each neighbour counts for at the point: a polynomial's value there is linear in them.
fn fit(table: &Table, own: &crate::table::Row, near: &[(f32, usize)], local: &Local) -> Vec<f32> {
    let reach = near.last().map_or(1.0, |n| n.0) * 1.05 + 1e-9;
    let polynomial: Vec<Vec<f64>> = near
        .iter()
        .map(|&(_, i)| table.rows[i].polynomial(own, reach, local.order))
        .collect();
    let terms = polynomial.first().map_or(1, Vec::len);
    let kernel: Vec<f64> = near
        .iter()
        .map(|&(d, i)| {
            let fall = f64::from(1.0 - (d / reach).powi(2)).max(0.02);
            let level = if local.relative {
                f64::from(table.rows[i].weight)
            } else {
                1.0
            };
            fall * level * level
        })
        .collect();
    let x = Array2::from_shape_fn((near.len(), terms), |(i, k)| polynomial[i][k]);
    let k = Array1::from(kernel.clone());
    let total = k.sum();
    let mut gram = x.t().dot(&(&x * &k.clone().insert_axis(ndarray::Axis(1))));
    for i in 0..terms {
        gram[[i, i]] += total * if i == 0 { 1e-9 } else { 1e-3 };
    }
    let mut unit = Array1::zeros(terms);
    unit[0] = 1.0;
    let enough = near.len() >= 2 * terms;
    let solved = gram.factorizec(UPLO::Lower).and_then(|f| f.solvec(&unit));
    match solved {
        Ok(z) if enough => {
            let own: Array1<f64> = x.dot(&z) * &k;
            own.slice(s![..]).iter().map(|&w| w as f32).collect()
        }
        _ => kernel.iter().map(|&w| (w / total) as f32).collect(),
    }
}
