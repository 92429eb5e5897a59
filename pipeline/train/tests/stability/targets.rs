//! Targets that are not what a net expects: fireflies, NaN, constants, edges.

use crate::cells::{self, Cell, smooth};
use rrf_train::FitEnd;

/// One target a million times too bright, as a path that found the light by chance leaves it:
/// in one half. The relative loss divides by it, so that it counts as one wrong row of many.
#[test]
fn one_target_a_million_times_the_rest() {
    let mut cell = Cell::new(900, 0.02, smooth);
    cell.halves[0][100] = [1e6; 3];
    let fit = cell.fit(&cells::config());
    let error = cell.error(&fit.model, smooth);
    assert!(error < 0.1 * cells::of_the_mean(&cell), "{error}");
}

/// Bad rows are left out, counted and named, and what stands in them has no influence at all:
/// the same rows bad in another way give the same bits.
#[test]
fn nan_and_infinite_targets_are_quarantined() {
    let plain = Cell::new(600, 0.02, smooth);
    let bad_rows = [3u32, 77, 300, 599];
    let spoil = |value: f32| {
        let mut cell = plain.clone();
        cell.halves[0][3][1] = value;
        cell.halves[1][77] = [value; 3];
        cell.column("px")[300] = value;
        cell.column("lz")[599] = value;
        cell.fit(&cells::config())
    };
    let fits = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY].map(spoil);
    for fit in &fits {
        assert_eq!(fit.quarantined, bad_rows);
        assert_eq!(fit.quarantined.len(), 4);
        assert_eq!(fit.train_rows + fit.validation_rows, 596);
        assert_eq!(fit.model.weights, fits[0].model.weights);
    }
    let whole = plain.fit(&cells::config());
    let [a, b] = [&whole, &fits[0]].map(|fit| plain.error(&fit.model, smooth));
    assert!(b < 1.5 * a, "{a} became {b}");
}

#[test]
fn nothing_but_nan() {
    let mut cell = Cell::new(50, 0.0, smooth);
    cell.halves[1].fill([f32::NAN; 3]);
    let fit = cell.fit(&cells::config());
    assert_eq!(fit.end, FitEnd::NoRows);
    assert_eq!(fit.quarantined.len(), 50);
}

#[test]
fn a_constant_target_is_a_constant() {
    let fit = Cell::new(300, 0.0, |_| [0.5, 0.25, 2.0]).fit(&cells::config());
    assert_eq!(fit.end, FitEnd::Constant);
    assert_eq!(fit.model.shape.sizes, [0, 3]);
    assert_eq!(fit.model.output_offset, [0.5, 0.25, 2.0]);
    let black = Cell::new(300, 0.0, |_| [0.0; 3]).fit(&cells::config());
    assert_eq!(black.end, FitEnd::Constant);
    assert_eq!(black.model.output_offset, [0.0; 3]);
}

/// A shadow's edge through the cell, oblique to all axes: no smooth net is exact, but the fit
/// ends and explains most of it. The constant leaves 0.9 of relative error.
#[test]
fn a_cell_cut_by_a_discontinuity() {
    let edge = |x: &cells::Row| [if x[0] + 0.7 * x[5] > 0.1 { 1.0 } else { 0.1 }; 3];
    let cell = Cell::new(1500, 0.0, edge);
    let fit = cell.fit(&cells::config());
    assert!(fit.history.len() <= cells::config().iterations);
    let error = cell.error(&fit.model, edge);
    assert!(error < 0.9, "{error}");
}

/// Targets as large and as small as f32 holds.
#[test]
fn targets_at_the_ends_of_f32() {
    for size in [1e-30, 1e30] {
        let cell = Cell::new(300, 0.0, |x| smooth(x).map(|y| size * y));
        let config = rrf_train::TrainConfig {
            mean_radiance: None,
            ..cells::config()
        };
        let fit = cell.fit(&config);
        let error = fit.validation_error.relative();
        assert!(error < 0.5, "{size}: {error}, {:?}", fit.end);
    }
}

/// One row in three lies on a wall behind, where no light comes. To the relative loss the mean is next
/// to nothing for the lit rows, and a net of exponents that starts from it stays there: an error of 1.
#[test]
fn lit_rows_are_learned_beside_black_ones() {
    let stream = rrf_sampling::Stream::new(9, rrf_sampling::Stage::Test, 0);
    let rows: Vec<cells::Row> = (0..3000)
        .map(|i| {
            let mut row = std::array::from_fn(|d| 2.0 * stream.f64(i, d as u32) - 1.0);
            row[0] += if i % 3 == 1 { 4.0 } else { 0.0 };
            row
        })
        .collect();
    let behind = |x: &cells::Row| x[0] > 2.0;
    let cell = Cell::of(&rows, 0.1, |x| if behind(x) { [0.0; 3] } else { smooth(x) });
    let config = rrf_train::TrainConfig {
        exponential: true,
        mean_radiance: Some(0.02),
        ..cells::config()
    };
    // the rows held out are lit ones
    let error = cell.fit(&config).validation_error;
    assert!(error.square + 3.0 * error.square_se < 0.5, "{error:?}");
}
