//! The batched field against the scalar net in f64.

#![allow(clippy::unwrap_used)]

mod common;

use common::{Numbers, model, rows, tree};
use rrf_field::columns::{self, Columns};
use rrf_field::model::CellModel;
use rrf_field::{EXP_ERROR, Field, Light, TANH_ERROR, Workspace, net};

/// The inputs of one row in f64, from their definitions.
fn inputs(rows: &Columns, r: usize) -> Vec<f64> {
    let row: Vec<f64> = rows.row(r).iter().map(|&x| f64::from(x)).collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let (p, n, v, l) = (&row[0..3], &row[3..6], &row[6..9], &row[9..12]);
    let to: Vec<f64> = l.iter().zip(p).map(|(l, p)| l - p).collect();
    let distance = dot(&to, &to).sqrt();
    let d: Vec<f64> = to.iter().map(|x| x / distance).collect();
    let mirror: Vec<f64> = (0..3).map(|i| 2.0 * dot(n, v) * n[i] - v[i]).collect();
    let derived = [
        d[0],
        d[1],
        d[2],
        1.0 / distance,
        dot(&mirror, &d),
        dot(n, &d),
        dot(n, v),
    ];
    row.iter().copied().chain(derived).collect()
}

/// The model at one row, in f64 throughout.
fn scalar(model: &CellModel, rows: &Columns, r: usize) -> [f64; 3] {
    let all = inputs(rows, r);
    let x: Vec<f64> = model
        .inputs
        .iter()
        .enumerate()
        .map(|(k, &i)| {
            (all[usize::from(i)] - f64::from(model.input_offset[k]))
                * f64::from(model.input_scale[k])
        })
        .collect();
    let weights: Vec<f64> = model.weights.iter().map(|&w| f64::from(w)).collect();
    let y = net::evaluate(&model.shape, &weights, &x);
    std::array::from_fn(|c| {
        let y = if model.exponential {
            y[c].min(f64::from(rrf_field::MAX_EXPONENT)).exp()
        } else {
            y[c]
        };
        let y = y * f64::from(model.output_scale[c]) + f64::from(model.output_offset[c]);
        if model.divide_base {
            y * all[columns::BASE + c]
        } else {
            y
        }
    })
}

/// Bound on what f32 adds to [`scalar`]: the running error of sums, layer by layer (Higham,
/// *Accuracy and Stability of Numerical Algorithms*, section 3.1), with the stated error of tanh.
fn rounding(model: &CellModel, rows: &Columns, r: usize) -> [f64; 3] {
    let unit = f64::from(f32::EPSILON) / 2.0;
    let all = inputs(rows, r);
    let (mut x, mut error) = (Vec::new(), Vec::new());
    for (k, &i) in model.inputs.iter().enumerate() {
        let (offset, scale) = (
            f64::from(model.input_offset[k]),
            f64::from(model.input_scale[k]),
        );
        let value = all[usize::from(i)];
        x.push((value - offset) * scale);
        // a derived input has some eight operations; offset and scale are worked into the weights
        error.push(10.0 * unit * (value.abs() + offset.abs()) * scale.abs());
    }
    let layers = model.shape.sizes.len() - 1;
    for (layer, start) in model.shape.offsets().into_iter().enumerate() {
        let (n_in, n_out) = (model.shape.sizes[layer], model.shape.sizes[layer + 1]);
        let unit_of = |j: usize| {
            let w = &model.weights[start + j * (n_in + 1)..][..n_in + 1];
            let w: Vec<f64> = w.iter().map(|&w| f64::from(w)).collect();
            let dot = |of: &[f64]| w[1..].iter().zip(of).map(|(w, x)| w * x).sum::<f64>();
            let size = |of: &[f64]| {
                w[1..]
                    .iter()
                    .zip(of)
                    .map(|(w, x)| (w * x).abs())
                    .sum::<f64>()
            };
            let sums = (n_in + 2) as f64 * unit * (w[0].abs() + size(&x));
            let (z, error) = (w[0] + dot(&x), size(&error) + sums);
            if layer + 1 == layers {
                return (z, error);
            }
            // the slope of tanh is 1 at most
            (z.tanh(), error + f64::from(TANH_ERROR) * z.tanh().abs())
        };
        (x, error) = (0..n_out).map(unit_of).unzip();
    }
    std::array::from_fn(|c| {
        let scale = f64::from(model.output_scale[c]).abs();
        let offset = f64::from(model.output_offset[c]).abs();
        let (mut y, mut error) = (x[c], error[c]);
        if model.exponential {
            y = y.min(f64::from(rrf_field::MAX_EXPONENT)).exp();
            error = y * error.exp_m1() + f64::from(EXP_ERROR) * y;
        }
        let bound = error * scale + 4.0 * unit * (y.abs() * scale + offset);
        if model.divide_base {
            bound * all[columns::BASE + c]
        } else {
            bound
        }
    })
}

fn field(cells: usize, inputs: &[u8], hidden: &[usize], seed: u64) -> Field {
    let mut numbers = Numbers::new(seed);
    let models = (0..cells as u32)
        .map(|cell| model(cell, inputs, hidden, &mut numbers))
        .collect();
    Field::new(tree(cells, seed), models).unwrap()
}

#[test]
fn batched_equals_scalar() {
    let all: Vec<u8> = (0..25).collect();
    let shuffled = [24, 3, 9, 18, 0, 22, 7, 12, 21, 1, 10];
    let cases: [(&[u8], &[usize]); 7] = [
        (&all[..12], &[20, 10]),
        (&all, &[40, 20]),
        (&shuffled, &[13, 7, 5]),
        (&all[..9], &[1]),
        (&all[..3], &[]),
        (&[24], &[3, 2]),
        // one colour all over
        (&[], &[]),
    ];
    let mut tightest = 0.0f64;
    for (case, (inputs, hidden)) in cases.into_iter().enumerate() {
        let field = field(9, inputs, hidden, 100 + case as u64);
        let rows = rows(3000, 200 + case as u64);
        let (mut out, mut cells) = (<[Vec<f32>; 3]>::default(), Vec::new());
        field.evaluate(&rows, &mut out, &mut cells).unwrap();
        let wanted: Vec<[f64; 3]> = (0..rows.len())
            .map(|r| scalar(&field.models()[cells[r] as usize], &rows, r))
            .collect();
        for (c, out) in out.iter().enumerate() {
            for (r, want) in wanted.iter().enumerate() {
                let error = (f64::from(out[r]) - want[c]).abs();
                let bound = rounding(&field.models()[cells[r] as usize], &rows, r)[c];
                assert!(
                    error <= bound,
                    "case {case} row {r} channel {c}: {error:e} of {bound:e}"
                );
                tightest = tightest.max(error / bound);
            }
        }
    }
    // the bound is no empty one
    assert!(tightest > 0.05, "{tightest}");
}

#[test]
fn the_batch_split_does_not_change_a_bit() {
    let field = field(17, &[0, 1, 2, 5, 9, 10, 11, 20, 21, 24], &[20, 10], 5);
    let rows = rows(1000, 6);
    let (mut whole, mut cells) = (<[Vec<f32>; 3]>::default(), Vec::new());
    field.evaluate(&rows, &mut whole, &mut cells).unwrap();
    for size in [1, 7, 64, 333] {
        let ids: Vec<u32> = (0..1000).collect();
        for part in ids.chunks(size) {
            let (mut out, mut part_cells) = (<[Vec<f32>; 3]>::default(), Vec::new());
            field
                .evaluate(&rows.take(part), &mut out, &mut part_cells)
                .unwrap();
            for (i, &r) in part.iter().enumerate() {
                assert_eq!(part_cells[i], cells[r as usize]);
                for c in 0..3 {
                    assert_eq!(out[c][i].to_bits(), whole[c][r as usize].to_bits());
                }
            }
        }
    }
}

#[test]
fn descent_equals_the_plain_tree() {
    let mut rows = rows(2000, 1);
    let mut numbers = Numbers::new(2);
    for special in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for _ in 0..50 {
            rows.columns[numbers.below(columns::COUNT)][numbers.below(2000)] = special;
        }
    }
    for cells in [1, 2, 60] {
        let field = field(cells, &[0], &[], 3);
        let mut got = Vec::new();
        field.cells(&rows, &mut got).unwrap();
        assert_eq!(got, field.tree().find_all(&rows));
    }
}

#[test]
fn a_row_with_nan_stays_nan_and_alone() {
    let field = field(1, &[0, 1, 2], &[20, 10], 8);
    let mut rows = rows(100, 9);
    let (mut clean, mut out, mut cells) = Default::default();
    field.evaluate(&rows, &mut clean, &mut cells).unwrap();
    rows.columns[columns::P][41] = f32::NAN;
    field.evaluate(&rows, &mut out, &mut cells).unwrap();
    for c in 0..3 {
        for r in 0..100 {
            assert_eq!(out[c][r].is_nan(), r == 41);
            assert!(r == 41 || out[c][r] == clean[c][r]);
        }
    }
}

#[test]
fn an_empty_batch_gives_empty_columns() {
    let field = field(3, &[0, 1], &[4], 8);
    let (mut out, mut cells) = ([vec![1.0], vec![], vec![2.0; 9]], vec![7]);
    field
        .evaluate(&Columns::default(), &mut out, &mut cells)
        .unwrap();
    assert!(cells.is_empty() && out.iter().all(Vec::is_empty));
}

#[test]
fn many_lights_are_the_sum_of_single_ones() {
    let inputs: Vec<u8> = (0..25).collect();
    let field = field(40, &inputs, &[20, 10], 12);
    let mut rows = rows(500, 13);
    let mut numbers = Numbers::new(14);
    let lights: Vec<Light> = (0..9)
        .map(|_| Light {
            position: std::array::from_fn(|_| numbers.next()),
            intensity: std::array::from_fn(|_| 1.0 + numbers.next()),
        })
        .collect();
    let mut all = <[Vec<f32>; 3]>::default();
    let mut first_cells = Vec::new();
    field
        .evaluate_lights(&rows, &lights, &mut all, &mut first_cells)
        .unwrap();

    let mut sum = vec![[0.0f64; 3]; rows.len()];
    let mut size = vec![[0.0f64; 3]; rows.len()];
    for light in &lights {
        for i in 0..3 {
            rows.columns[columns::L + i].fill(light.position[i]);
        }
        let (mut one, mut cells) = (<[Vec<f32>; 3]>::default(), Vec::new());
        field.evaluate(&rows, &mut one, &mut cells).unwrap();
        let unit = Light {
            intensity: [1.0; 3],
            ..*light
        };
        let mut alone = <[Vec<f32>; 3]>::default();
        let mut alone_cells = Vec::new();
        field
            .evaluate_lights(&rows, &[unit], &mut alone, &mut alone_cells)
            .unwrap();
        assert_eq!(alone_cells, cells);
        for (c, (alone, one)) in alone.iter().zip(&one).enumerate() {
            let square: f64 = one.iter().map(|&y| f64::from(y).powi(2)).sum();
            let rms = (square / one.len() as f64).sqrt();
            for (r, (&a, &b)) in alone.iter().zip(one).enumerate() {
                // As the batched net against the scalar one: a light's share of the first layer
                // is summed in another order.
                let (a, b) = (f64::from(a), f64::from(b));
                let error = (a - b).abs() / b.abs().max(0.1 * rms);
                assert!(error < 1e-5, "row {r} channel {c}: {error:e}");
            }
        }
        if light == &lights[0] {
            assert_eq!(first_cells, cells);
        }
        for r in 0..rows.len() {
            for c in 0..3 {
                let y = f64::from(light.intensity[c]) * f64::from(one[c][r]);
                sum[r][c] += y;
                size[r][c] += y.abs();
            }
        }
    }
    // Each light within 1e-5 of its own size, as above.
    for r in 0..rows.len() {
        for c in 0..3 {
            let error = (f64::from(all[c][r]) - sum[r][c]).abs();
            assert!(error <= 1e-5 * size[r][c], "row {r} channel {c}: {error:e}");
        }
    }
}

/// What a light adds to the first layer once for all rows, against the scalar net; on any split
/// of the batch the same bits.
#[test]
fn lights_equal_scalar() {
    let all: Vec<u8> = (0..25).collect();
    let shuffled = [24, 3, 9, 18, 0, 22, 7, 12, 21, 1, 10];
    let cases: [(&[u8], &[usize]); 6] = [
        (&all[..12], &[20, 10]),
        (&all, &[40, 20]),
        (&shuffled, &[13, 7, 5]),
        (&[9, 10, 11], &[5]),
        (&all[..3], &[]),
        (&[], &[]),
    ];
    for (case, (inputs, hidden)) in cases.into_iter().enumerate() {
        let field = field(9, inputs, hidden, 300 + case as u64);
        let mut rows = rows(1500, 400 + case as u64);
        let light = Light {
            position: [0.3, -0.4, 0.2],
            intensity: [1.0; 3],
        };
        let lit = field.under(&[light]);
        let (mut out, mut cells) = (<[Vec<f32>; 3]>::default(), Vec::new());
        let mut work = Workspace::default();
        lit.evaluate(&rows, &mut work, &mut out, &mut cells, None)
            .unwrap();
        for ids in (0..1500).collect::<Vec<u32>>().chunks(77) {
            let (mut part, mut part_cells) = (<[Vec<f32>; 3]>::default(), Vec::new());
            lit.evaluate(&rows.take(ids), &mut work, &mut part, &mut part_cells, None)
                .unwrap();
            for (i, &r) in ids.iter().enumerate() {
                for c in 0..3 {
                    assert_eq!(part[c][i].to_bits(), out[c][r as usize].to_bits());
                }
            }
        }
        for i in 0..3 {
            rows.columns[columns::L + i].fill(light.position[i]);
        }
        let wanted: Vec<[f64; 3]> = (0..rows.len())
            .map(|r| scalar(&field.models()[cells[r] as usize], &rows, r))
            .collect();
        for (c, out) in out.iter().enumerate() {
            let square = wanted.iter().map(|y| y[c] * y[c]).sum::<f64>();
            let rms = (square / rows.len() as f64).sqrt();
            for (r, want) in wanted.iter().enumerate() {
                let error = (f64::from(out[r]) - want[c]).abs() / want[c].abs().max(0.1 * rms);
                assert!(error < 1e-5, "case {case} row {r} channel {c}: {error:e}");
            }
        }
    }
}
