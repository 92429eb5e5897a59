//! What nets are compared with.

use crate::cells::{Cell, Row, smooth};
use rrf_field::Field;
use rrf_field::columns::Columns;
use rrf_field::model::CellModel;
use rrf_field::tree::Tree;
use rrf_train::Samples;
use rrf_train::{
    Batches, CellFit, FitEnd, Kind, Schedule, Start, TrainConfig, TrainError, fit_cell, fit_from,
};

pub fn config(kind: Kind) -> TrainConfig {
    let inputs = ["px", "py", "vx", "vy", "vz", "lx", "ly", "lz"];
    TrainConfig {
        kind,
        inputs: inputs.map(String::from).to_vec(),
        ..TrainConfig::default()
    }
}

fn fit(cell: &Cell, config: &TrainConfig) -> CellFit {
    let [a, b] = [&cell.halves[0], &cell.halves[1]].map(Vec::as_slice);
    fit_cell(3, &cell.columns, [a, b], &cell.validation, config).unwrap()
}

fn answers(model: &CellModel, rows: &Columns) -> [Vec<f32>; 3] {
    let alone = CellModel {
        cell: 0,
        ..model.clone()
    };
    let field = Field::new(Tree::single(), vec![alone]).unwrap();
    let mut out = Default::default();
    field.evaluate(rows, &mut out, &mut Vec::new()).unwrap();
    out
}

/// A polynomial of the second degree, positive in ±1.
fn polynomial([px, py, vx, _, vz, lx, ly, lz]: &Row) -> [f64; 3] {
    let y = 4.0 + 0.5 * px - 0.3 * ly + 0.7 * px * lx - 0.4 * py * py + 0.2 * vx * lz;
    [y, 0.5 * y + 0.3 * lz * lz, 1.5 + 0.4 * vz * py]
}

#[test]
fn a_quadratic_is_fitted_to_rounding() {
    let cell = Cell::new(1200, 0.0, polynomial);
    let fit = fit(&cell, &config(Kind::Quadratic));
    assert_eq!((fit.end, fit.history.len()), (FitEnd::Solved, 0));
    // 8 inputs: 1 + 8 + 36 terms
    assert_eq!(
        (fit.model.kind, fit.model.weights.len()),
        (Kind::Quadratic, 135)
    );
    let found = answers(&fit.model, &cell.columns);
    for (c, found) in found.iter().enumerate() {
        for (row, y) in found.iter().enumerate() {
            let target = cell.halves[0][row][c];
            // 45 coefficients and 8 inputs are rounded to f32, as the targets are
            assert!(
                (y - target).abs() < 64.0 * f32::EPSILON * 4.0,
                "{y} {target}"
            );
        }
    }
    assert!(fit.validation_error.square < 1e-10);
}

/// With absolute errors the residuals on the training rows are orthogonal to every term, but for the
/// ridge: Σ φ (out − y) = −ridge · mean(Σ φ²) · coefficient. Terms and sums are made here again.
#[test]
fn a_quadratic_solves_its_normal_equations() {
    let cell = Cell::new(900, 0.05, smooth);
    let config = TrainConfig {
        relative: false,
        ..config(Kind::Quadratic)
    };
    let fit = fit(&cell, &config);
    let model = &fit.model;
    let (n, count) = (8, 45);
    let names = ["px", "py", "vx", "vy", "vz", "lx", "ly", "lz"];
    let (mut gradient, mut size, mut sums) = (vec![0.0; count], vec![0.0; count], vec![0.0; count]);
    let mut cell = cell;
    let columns = names.map(|name| cell.column(name).clone());
    for row in (0..cell.columns.len()).filter(|&row| !cell.validation[row]) {
        let h: Vec<f64> = (0..n)
            .map(|i| f64::from((columns[i][row] - model.input_offset[i]) * model.input_scale[i]))
            .collect();
        let mut phi = vec![1.0];
        phi.extend(&h);
        for i in 0..n {
            phi.extend((i..n).map(|j| h[i] * h[j]));
        }
        let out: f64 = phi
            .iter()
            .zip(&model.weights)
            .map(|(p, w)| p * f64::from(*w))
            .sum();
        let y = 0.5 * (f64::from(cell.halves[0][row][0]) + f64::from(cell.halves[1][row][0]));
        let y = (y - f64::from(model.output_offset[0])) / f64::from(model.output_scale[0]);
        for k in 0..count {
            gradient[k] += phi[k] * (out - y);
            size[k] += phi[k].abs() * (out - y).abs();
            sums[k] += phi[k] * phi[k];
        }
    }
    let mean = sums.iter().sum::<f64>() / count as f64;
    for k in 0..count {
        let pull = fit.alpha * mean * f64::from(model.weights[k]);
        // coefficients are stored as f32: each moves the sums by that share of themselves
        let rounding = f64::from(f32::EPSILON) * count as f64 * (size[k] + sums[k]);
        assert!(
            (gradient[k] + pull).abs() < rounding,
            "{k}: {} {pull}",
            gradient[k]
        );
    }
}

#[test]
fn the_nearest_rows_are_the_rows_trained_on() {
    let cell = Cell::new(500, 0.05, smooth);
    let fit = fit(&cell, &config(Kind::Nearest));
    let rows = cell.validation.iter().filter(|held| !**held).count();
    assert_eq!(fit.model.shape.sizes, [8, rows, 3]);
    assert_eq!(fit.model.weights.len(), rows * 11);
    let found = answers(&fit.model, &cell.columns);
    for row in (0..cell.columns.len()).filter(|&row| !cell.validation[row]) {
        for (c, found) in found.iter().enumerate() {
            let y = 0.5 * (cell.halves[0][row][c] + cell.halves[1][row][c]);
            let scale =
                fit.model.output_scale[c].abs() + fit.model.output_offset[c].abs() + y.abs();
            assert!((found[row] - y).abs() < 8.0 * f32::EPSILON * scale);
        }
    }
    // the error reported is of rows held out, which are not among them
    assert!(fit.validation_error.relative() > 0.05);
}

#[test]
fn few_rows_and_dark_ones_give_a_model() {
    for kind in [Kind::Quadratic, Kind::Nearest] {
        // fewer rows than terms: only a ridge makes them solvable
        let few = fit(&Cell::new(20, 0.05, smooth), &config(kind));
        assert!(few.model.weights.iter().all(|w| w.is_finite()), "{kind:?}");
        assert_eq!(few.end, FitEnd::Solved);
        let dark = fit(&Cell::new(50, 0.0, |_| [0.0; 3]), &config(kind));
        assert_eq!((dark.end, dark.model.kind), (FitEnd::Constant, Kind::Net));
        let none = fit(&Cell::new(0, 0.0, smooth), &config(kind));
        assert_eq!(none.end, FitEnd::NoRows);
    }
}

#[test]
fn what_only_nets_can_do_is_refused() {
    let cell = Cell::new(50, 0.0, smooth);
    let samples = Samples {
        rows: &cell.columns,
        halves: [&cell.halves[0], &cell.halves[1]],
        validation: &cell.validation,
    };
    let batches = Batches { rows: 10, steps: 1 };
    let of = |change: fn(&mut TrainConfig, Batches)| {
        let mut config = config(Kind::Quadratic);
        change(&mut config, batches);
        fit_from(Start::default(), 0, samples, &config).map(|_| ())
    };
    let refused = Err(TrainError::NoNet { kind: "quadratic" });
    assert_eq!(of(|c, batches| c.mode = Schedule::Online(batches)), refused);
    assert_eq!(of(|c, _| c.prune = Some(0.1)), refused);
    assert_eq!(of(|c, _| c.exponential = true), refused);
    assert_eq!(of(|_, _| ()), Ok(()));
    let probes = |c: &mut TrainConfig, _| c.kind = Kind::Probes;
    assert_eq!(of(probes), Err(TrainError::Glossy));
}
