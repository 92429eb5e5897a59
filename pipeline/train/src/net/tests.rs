//! The structured normal equations against a dense Jacobian, and whole fits.

use crate::net::blocks::Precision;
use crate::net::problem::{Loss, NetProblem};
use crate::net::simd::TILE_ROWS;
use crate::net::synthetic::{self, RandomRows};
use rrf_field::net::{self, Shape};
use rrf_lm::{NormalEquations, Problem};

/// JᵀWJ, JᵀWr and D with J formed column by column from dual numbers; `exponential` outputs by
/// the chain rule.
fn dense(
    shape: &Shape,
    w: &[f64],
    rows: &RandomRows,
    floor: f64,
    exponential: bool,
) -> (NormalEquations, f64) {
    let n = w.len();
    let (mut normal, mut cost) = (NormalEquations::zeros(n), 0.0);
    for row in 0..rows.rows {
        let (x, target, gain, base) = rows.row(row, shape.sizes[0]);
        let mut out = net::evaluate(shape, w, &x);
        if exponential {
            out.iter_mut().for_each(|out| *out = out.exp());
        }
        let lum: f64 = base + (0..3).map(|c| gain[c] * target[c]).sum::<f64>() / 3.0;
        let columns: Vec<Vec<f64>> = (0..n)
            .map(|i| {
                let mut e = vec![0.0; n];
                e[i] = 1.0;
                let mut slope = synthetic::derivative(shape, w, &e, &x).1;
                if exponential {
                    slope.iter_mut().zip(&out).for_each(|(s, out)| *s *= out);
                }
                slope
            })
            .collect();
        for c in 0..3 {
            let s = gain[c] / lum.max(floor);
            let r = s * (out[c] - target[c]);
            cost += r * r;
            for i in 0..n {
                normal.gradient[i] += s * columns[i][c] * r;
                for j in 0..n {
                    normal.matrix[i * n + j] += s * s * columns[i][c] * columns[j][c];
                }
            }
        }
    }
    (normal, cost)
}

fn close(a: &[f64], b: &[f64], tolerance: f64) {
    let size = b.iter().fold(0.0f64, |m, b| m.max(b.abs()));
    for (i, (a, b)) in a.iter().zip(b).enumerate() {
        assert!(
            (a - b).abs() <= tolerance * size,
            "{i}: {a} {b}, size {size}"
        );
    }
}

#[test]
fn structured_equals_dense() {
    let shapes: [&[usize]; 6] = [
        &[5, 3],
        &[3, 4, 3],
        &[7, 9, 6, 3],
        &[1, 1, 1, 3],
        &[0, 3],
        &[10, 20, 10, 3],
    ];
    for sizes in shapes {
        let shape = Shape {
            sizes: sizes.to_vec(),
        };
        let w = synthetic::weights(&shape, 3, 0.8);
        for (count, exponential) in [1, 2, 128, 131, 300]
            .into_iter()
            .zip([true, false].into_iter().cycle())
        {
            let rows = RandomRows {
                seed: 5,
                rows: count,
            };
            let loss = Loss::Relative {
                floor: 1.3,
                noise: 0.01,
            };
            let mut problem =
                NetProblem::new(&shape, &rows, 3 * count, loss).exponential(exponential);
            let mut normal = NormalEquations::zeros(w.len());
            let cost = problem.linearise(&w, &mut normal);
            let (expected, expected_cost) = dense(&shape, &w, &rows, 1.3, exponential);
            close(&normal.matrix, &expected.matrix, 1e-12);
            close(&normal.gradient, &expected.gradient, 1e-12);
            close(&[cost, problem.cost(&w)], &[expected_cost; 2], 1e-12);
            let mut problem =
                NetProblem::new(&shape, &rows, 3 * count, loss).exponential(exponential);
            let mut found = vec![0.0; w.len()];
            let cost = problem.gradient(&w, &mut found).unwrap();
            close(&[cost], &[expected_cost], 1e-12);
            close(&found, &expected.gradient, 1e-12);
            let v = synthetic::weights(&shape, 4, 1.0);
            let expected: Vec<f64> = (expected.matrix.chunks(w.len()))
                .map(|row| row.iter().zip(&v).map(|(a, v)| a * v).sum())
                .collect();
            for _ in 0..2 {
                assert!(problem.product(&v, &mut found));
                close(&found, &expected, 1e-12);
            }
        }
    }
}

/// f32 products: a sum of n of them errs by n units of 2^-24 of the sum of their magnitudes, which for
/// rows of JᵀWJ is at most the geometric mean of two diagonal entries (Cauchy-Schwarz). The
/// factors are products of two and three rounded numbers and sums over channels: 6 units more.
/// The gradient and the cost are those in f64, to the bit.
#[test]
fn single_precision_is_as_good_as_its_numbers() {
    let shape = Shape {
        sizes: vec![7, 9, 6, 3],
    };
    let w = synthetic::weights(&shape, 3, 0.8);
    let rows = RandomRows { seed: 5, rows: 300 };
    let with = |precision| {
        let mut problem = NetProblem::new(&shape, &rows, 900, Loss::Absolute).precision(precision);
        let mut normal = NormalEquations::zeros(w.len());
        let cost = problem.linearise(&w, &mut normal);
        (normal, cost)
    };
    let ((double, cost), (single, same)) = (with(Precision::Double), with(Precision::Single));
    assert_eq!((cost, &double.gradient), (same, &single.gradient));
    assert_ne!(double.matrix, single.matrix);
    let n = w.len();
    let unit = f64::from(f32::EPSILON) / 2.0;
    for (at, (a, b)) in double.matrix.iter().zip(&single.matrix).enumerate() {
        let [i, j] = [at / n, at % n].map(|i| double.matrix[i * n + i]);
        let bound = (TILE_ROWS as f64 + 6.0) * unit * (i * j).sqrt();
        assert!((a - b).abs() <= bound, "{a} {b}");
    }
}

/// The dual numbers against central differences of the plain evaluation: an independent check
/// of the reference itself. Error of a central difference: h² f'''/6 + ulp/h, about 1e-9 here.
#[test]
fn dual_numbers_equal_central_differences() {
    let shape = Shape {
        sizes: vec![4, 6, 5, 3],
    };
    let w = synthetic::weights(&shape, 1, 1.0);
    let v = synthetic::weights(&shape, 2, 1.0);
    let x = [0.3, -1.2, 0.8, 0.1];
    let h = 1e-5;
    let at = |t: f64| -> Vec<f64> {
        let moved: Vec<f64> = w.iter().zip(&v).map(|(w, v)| w + t * v).collect();
        net::evaluate(&shape, &moved, &x)
    };
    let (_, slope) = synthetic::derivative(&shape, &w, &v, &x);
    for (c, (a, b)) in at(h).iter().zip(at(-h)).enumerate() {
        assert!(((a - b) / (2.0 * h) - slope[c]).abs() < 1e-8);
    }
}

/// JᵀW r'' against the second central difference of the plain evaluation along v. Its error is
/// h²/12 of the fourth derivative and 4 ulp/h²: below 1e-5 of the values here.
#[test]
fn curvature_equals_second_differences() {
    for exponential in [false, true] {
        check_curvature(exponential);
    }
}

fn check_curvature(exponential: bool) {
    let shape = Shape {
        sizes: vec![4, 6, 5, 3],
    };
    let rows = RandomRows { seed: 8, rows: 150 };
    let w = synthetic::weights(&shape, 1, 0.9);
    let v = synthetic::weights(&shape, 2, 0.9);
    let mut problem = NetProblem::new(&shape, &rows, 450, Loss::Absolute).exponential(exponential);
    problem.linearise(&w, &mut NormalEquations::zeros(w.len()));
    let mut found = vec![0.0; w.len()];
    assert!(problem.curvature(&w, &v, &mut found));
    let h = 1e-3;
    let mut expected = vec![0.0; w.len()];
    for row in 0..rows.rows {
        let (x, _, gain, _) = rows.row(row, 4);
        let at = |t: f64| {
            let moved: Vec<f64> = w.iter().zip(&v).map(|(w, v)| w + t * v).collect();
            let mut out = net::evaluate(&shape, &moved, &x);
            if exponential {
                out.iter_mut().for_each(|out| *out = out.exp());
            }
            out
        };
        let (ahead, here, behind) = (at(h), at(0.0), at(-h));
        for (i, expected) in expected.iter_mut().enumerate() {
            let mut e = vec![0.0; w.len()];
            e[i] = 1.0;
            let slope = synthetic::derivative(&shape, &w, &e, &x).1;
            for c in 0..3 {
                let slope = if exponential {
                    slope[c] * here[c]
                } else {
                    slope[c]
                };
                let second = (ahead[c] - 2.0 * here[c] + behind[c]) / (h * h);
                *expected += gain[c] * gain[c] * slope * second;
            }
        }
    }
    close(&found, &expected, 1e-5);
}

/// A product of powers over two decades: exponential outputs follow it several times better than
/// the same net with linear ones (medians: fits from other first weights differ by ten times), and a
/// channel without light stays dark.
#[test]
fn exponents_follow_a_product() {
    let mut rows = rrf_field::columns::Columns::default();
    let mut y = Vec::new();
    for r in 0..2000u64 {
        let mut row = [0.5; rrf_field::columns::COUNT];
        for (d, x) in row.iter_mut().take(3).enumerate() {
            *x = synthetic::uniform(12, r, d as u32) as f32;
        }
        let value = (1.5 * row[0] - row[1]).exp() / (0.3 + row[2] * row[2]);
        rows.push(row);
        y.push([value, 2.0 * value, 0.0]);
    }
    let held_out: Vec<bool> = (0..2000).map(|r| r % 3 == 0).collect();
    let error = |exponential: bool, seed: u64| {
        let config = crate::TrainConfig {
            seed,
            size: crate::Size::Hidden(vec![6, 4]),
            exponential,
            ..crate::TrainConfig::default()
        };
        let fit = crate::fit_cell(0, &rows, [&y, &y], &held_out, &config).unwrap();
        assert_eq!(fit.model.exponential, exponential);
        if exponential {
            assert_eq!(
                (fit.model.output_scale[2], fit.model.output_offset),
                (0.0, [0.0; 3])
            );
        }
        fit.validation_error.square.sqrt()
    };
    let [linear, exponential] = [false, true].map(|exponential| {
        let mut errors: Vec<f64> = (1..=11).map(|seed| error(exponential, seed)).collect();
        errors.sort_by(f64::total_cmp);
        errors[5]
    });
    assert!(exponential < 0.5 * linear, "{exponential} {linear}");
    assert!(exponential < 0.01, "{exponential}");
}
