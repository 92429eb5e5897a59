//! Errors of cells on rows that nothing was fitted to, and what they decide.

use crate::model::{LightCoefficients, TransferModel};
use crate::regression::RowTable;
use glam::Vec3;

/// Noise-free squared relative error of each judging row: mean over lights.
pub(crate) fn squares(
    model: &TransferModel,
    table: &RowTable,
    rows: &[u32],
    lights: &[LightCoefficients],
) -> Vec<f64> {
    let queries: Vec<_> = rows
        .iter()
        .map(|&row| table.queries[row as usize])
        .collect();
    let answers: Vec<_> = lights
        .iter()
        .map(|light| model.evaluate(light, &queries))
        .collect();
    let mean = |l: usize| {
        let of = |&row: &u32| {
            let halves = table.judged[row as usize].get(6 * l..6 * l + 6);
            halves.map_or(0.0, |h| f64::from(h.iter().sum::<f32>()) / 6.0)
        };
        rows.iter().map(of).sum::<f64>() / rows.len().max(1) as f64
    };
    let all = (0..lights.len()).map(mean).sum::<f64>() / lights.len().max(1) as f64;
    let floor = (0.05 * all).max(f64::MIN_POSITIVE);
    (rows.iter().enumerate())
        .map(|(i, &row)| {
            let judged = &table.judged[row as usize];
            let of = |l: usize| {
                let halves = &judged[6 * l..6 * l + 6];
                let (a, b) = (Vec3::from_slice(halves), Vec3::from_slice(&halves[3..]));
                let answer = answers[l][i].radiance;
                let level = f64::from((a + b).element_sum() / 6.0).max(floor);
                f64::from(((answer - a) * (answer - b)).element_sum() / 3.0) / (level * level)
            };
            (0..lights.len()).map(of).sum::<f64>() / lights.len().max(1) as f64
        })
        .collect()
}

/// Mean squared error of each cell, and how many rows judged it.
pub(crate) fn by_cell(
    model: &TransferModel,
    table: &RowTable,
    rows: &[u32],
    squares: &[f64],
) -> Vec<(f64, usize)> {
    let mut sums = vec![(0.0, 0); model.cells.len()];
    for (&row, square) in rows.iter().zip(squares) {
        if let Some(cell) = model.tree.find(&table.queries[row as usize]) {
            sums[cell as usize].0 += square;
            sums[cell as usize].1 += 1;
        }
    }
    (sums.into_iter())
        .map(|(sum, count)| (sum / count.max(1) as f64, count))
        .collect()
}

/// Root of a mean of squares; noise can make that negative.
pub(crate) fn root(mean: f64) -> f32 {
    mean.max(0.0).sqrt() as f32
}
