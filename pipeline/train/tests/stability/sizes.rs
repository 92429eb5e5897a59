//! Too few samples.

use crate::cells::{self, Cell, smooth};
use rrf_train::{Decay, FitEnd, Size, TrainConfig};

/// 60 rows for 503 weights: the evidence holds the net back, validation picks the weights.
#[test]
fn fewer_samples_than_weights() {
    let cell = Cell::new(60, 0.02, smooth);
    let config = TrainConfig {
        size: Size::Hidden(vec![20, 10]),
        ..cells::config()
    };
    let fit = cell.fit(&config);
    assert!(fit.model.weights.len() > 3 * fit.train_rows);
    assert!(fit.effective_parameters <= fit.model.weights.len() as f64);
    let constant = cell.fit(&TrainConfig {
        inputs: vec!["nz".into()],
        ..config.clone()
    });
    assert_eq!(constant.end, FitEnd::Constant);
    let [net, mean] = [&fit, &constant].map(|fit| fit.validation_error.relative());
    assert!(net < mean, "{net}, the mean alone {mean}");
    // without any decay the equations are singular; the damping alone must do
    cell.fit(&TrainConfig {
        decay: Decay::Fixed(0.0),
        ..config
    });
}

#[test]
fn one_sample_and_none() {
    let one = Cell::new(1, 0.0, smooth);
    let fit = one.fit(&cells::config());
    assert_eq!((fit.end, fit.train_rows), (FitEnd::Constant, 1));
    assert!(one.error(&fit.model, smooth) < 1e-6);
    let none = Cell::new(0, 0.0, smooth).fit(&cells::config());
    assert_eq!((none.end, none.rows), (FitEnd::NoRows, 0));
    assert_eq!(none.model.output_offset, [0.0; 3]);
}

#[test]
fn two_samples() {
    let cell = Cell::new(2, 0.0, smooth);
    let fit = cell.fit(&cells::config());
    assert_eq!(fit.train_rows, 2);
}

#[test]
fn all_rows_kept_back() {
    let mut cell = Cell::new(30, 0.0, smooth);
    cell.validation.fill(true);
    let fit = cell.fit(&cells::config());
    assert_eq!((fit.end, fit.validation_rows), (FitEnd::NoRows, 30));
}

#[test]
fn no_row_kept_back() {
    let mut cell = Cell::new(600, 0.0, smooth);
    cell.validation.fill(false);
    let fit = cell.fit(&cells::config());
    assert_eq!(fit.validation_rows, 0);
    assert!(cell.error(&fit.model, smooth) < 0.1);
}
