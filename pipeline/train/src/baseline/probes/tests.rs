//! Probes against fields that they can follow exactly, and against a dense solution.

use super::*;
use crate::config::TrainConfig;
use crate::rows::samples::Samples;
use rrf_field::columns::{BASE, COUNT, Columns};
use rrf_field::model::Kind;
use rrf_lm::Cholesky;
use rrf_sampling::{Stage, Stream};

const SMALL: Grid = Grid {
    places: 2,
    lights: 2,
};

const TO_THE_END: Effort = Effort {
    steps: 2000,
    enough: 1e-9,
};

/// Rows in a box of place and light, any normal, some base colours.
fn rows(count: usize) -> Columns {
    let mut random = Stream::new(9, Stage::Test, 0).dimensions(0);
    let mut number = || 2.0 * random.next_f32() - 1.0;
    let mut rows = Columns::default();
    for _ in 0..count {
        let mut row: [f32; COUNT] = std::array::from_fn(|_| number());
        let n = [row[N], row[N + 1], row[N + 2]];
        let length = n.iter().map(|x| x * x).sum::<f32>().sqrt();
        row[N..N + 3].iter_mut().for_each(|x| *x /= length);
        row[BASE..BASE + 3]
            .iter_mut()
            .for_each(|b| *b = 0.5 + 0.4 * *b);
        rows.push(row);
    }
    rows
}

/// Linear along each axis of place and light, of second degree in the normal, positive.
fn field(row: &[f32; COUNT]) -> [f32; 3] {
    let x = row.map(f64::from);
    let (p, n, l) = (&x[P..P + 3], &x[N..N + 3], &x[L..L + 3]);
    let place = 3.0 + p[0] - 0.5 * p[1] * p[2];
    let light = 2.0 - 0.7 * l[1] + 0.3 * l[0] * l[2];
    let normal = 2.0 + 0.5 * n[1] - 0.3 * n[0] * n[2] + 0.4 * n[2] * n[2];
    let tint = [1.0, 0.5 + 0.1 * n[0], 1.5 - 0.2 * n[1] * n[0]];
    std::array::from_fn(|c| (x[BASE + c] * place * light * (normal + tint[c])) as f32)
}

fn with_cell<T>(count: usize, see: impl FnOnce(&Cell, &Columns) -> T) -> T {
    let rows = rows(count);
    let y: Vec<[f32; 3]> = (0..count).map(|row| field(&rows.row(row))).collect();
    let samples = Samples {
        rows: &rows,
        halves: [&y, &y],
        validation: &vec![false; count],
    };
    let config = TrainConfig {
        kind: Kind::Probes,
        divide_base: true,
        ..TrainConfig::default()
    };
    let mut cell = Cell::new(0, samples, crate::Start::default(), &config).unwrap();
    let inputs = inputs(&cell, SMALL);
    cell.set_inputs(inputs);
    see(&cell, &rows)
}

/// 576 coefficients a channel from 4,000 rows: what they can follow they follow.
#[test]
fn a_field_in_their_span_is_found() {
    with_cell(4000, |cell, _| {
        let mut weighing = Weighing::new(cell);
        let found = solve_with(&mut weighing, SMALL, 1e-6, TO_THE_END).unwrap();
        weighing.each(|row| {
            let out = outputs(&found, &basis(SMALL, row));
            for (out, target) in out.into_iter().zip(row.target) {
                // inputs and targets are rounded to f32
                let difference = (out - target).abs();
                assert!(difference < 1e-5, "{difference}");
            }
        });
    });
}

/// Conjugate gradients end where (Aᵀ W² A + λ²) x = Aᵀ W² y, formed and solved densely.
#[test]
fn they_solve_their_normal_equations() {
    with_cell(700, |cell, _| {
        let (weighing, ridge) = (Weighing::new(cell), 0.3);
        let n = SMALL.coefficients().unwrap();
        let mut found = vec![[0.0; CHANNELS]; n];
        let system = System {
            weighing: &weighing,
            grid: SMALL,
            ridge,
        };
        system.solve(&mut found, TO_THE_END);
        let c = 1;
        let (mut matrix, mut right) = (vec![0.0; n * n], vec![0.0; n]);
        weighing.each(|row| {
            let (b, w) = (basis(SMALL, row), row.weight[c] * row.weight[c]);
            let mut phi = vec![0.0; n];
            for (first, share) in b.first.iter().zip(b.share) {
                for (h, harmonic) in b.harmonics.iter().enumerate() {
                    phi[first + h] += share * harmonic;
                }
            }
            for i in 0..n {
                right[i] += w * phi[i] * row.target[c];
                for j in i..n {
                    matrix[i * n + j] += w * phi[i] * phi[j];
                }
            }
        });
        let mut factor = Cholesky::default();
        factor.factor(&matrix, &vec![ridge * ridge; n]).unwrap();
        factor.solve(&mut right).unwrap();
        let largest = right.iter().fold(0.0f64, |a, b| a.max(b.abs()));
        for (found, wanted) in found.iter().zip(&right) {
            assert!(
                (found[c] - wanted).abs() < 1e-5 * largest,
                "{} {wanted}",
                found[c]
            );
        }
    });
}
