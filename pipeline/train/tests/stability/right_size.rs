//! The smallest model that will do, and no input that earns nothing.

use crate::cells::{self, Cell, Row, smooth};
use rrf_train::{FitEnd, Size, TrainConfig};

fn smallest(target: f64) -> TrainConfig {
    TrainConfig {
        size: Size::Smallest { target },
        prune: Some(0.0),
        ..cells::config()
    }
}

/// Linear in px and lz: a linear model of these two inputs, the others named as dropped.
#[test]
fn linear() {
    let y = |x: &Row| [2.0 + x[0], 2.0 - 0.5 * x[7], 2.0 + 0.5 * x[0] + 0.5 * x[7]];
    let cell = Cell::new(900, 0.02, y);
    let fit = cell.fit(&smallest(0.02));
    assert_eq!(fit.model.shape.sizes, [2, 3]);
    assert_eq!(cells::names(&fit.model.inputs), ["px", "lz"]);
    assert_eq!(
        cells::names(&fit.dropped_inputs),
        ["py", "vx", "vy", "vz", "lx", "ly"]
    );
    assert_eq!(fit.end, FitEnd::Target);
    assert!(cell.error(&fit.model, y) < 0.02);
}

/// A sum of two ridge functions: one small hidden layer, two inputs.
#[test]
fn separable() {
    let y = |x: &Row| [1.5 + (2.0 * x[0]).tanh(), 1.5 + (2.0 * x[5]).tanh(), 1.5];
    let cell = Cell::new(900, 0.02, y);
    let fit = cell.fit(&smallest(0.03));
    assert_eq!(fit.model.shape.sizes.len(), 3);
    assert!(fit.model.shape.sizes[1] <= 4);
    assert_eq!(cells::names(&fit.model.inputs), ["px", "lx"]);
}

/// The same cell given 20 and 10 units and leave to lose a fifth: a small net, fitted anew, in place of
/// what could be taken out of the large one.
#[test]
fn too_large() {
    let y = |x: &Row| [1.5 + (2.0 * x[0]).tanh(), 1.5 + (2.0 * x[5]).tanh(), 1.5];
    let cell = Cell::new(900, 0.02, y);
    let given = |prune| TrainConfig {
        size: Size::Hidden(vec![20, 10]),
        prune,
        ..cells::config()
    };
    let [large, small] = [None, Some(0.2)].map(|prune| cell.fit(&given(prune)));
    assert_eq!(large.model.shape.sizes[1..], [20, 10, 3]);
    let error = |fit: &rrf_train::CellFit| cell.error(&fit.model, y);
    assert_eq!(small.history.len(), small.history.len());
    assert!(
        small.model.weights.len() <= 24,
        "{:?}",
        small.model.shape.sizes
    );
    assert!(
        error(&small) < 0.01,
        "{} of {}",
        error(&small),
        error(&large)
    );
}

/// Radiance that does not depend on v (nor on lz): both are found out.
#[test]
fn independent_of_the_viewer() {
    let cell = Cell::new(1500, 0.02, smooth);
    let fit = cell.fit(&smallest(0.05));
    let names = cells::names(&fit.model.inputs);
    assert!(names.iter().all(|name| !name.starts_with('v')), "{names:?}");
    assert!(names.contains(&"px") && names.contains(&"lx"), "{names:?}");
    assert!(fit.validation_error.relative() <= 0.05);
}

/// A constant under noise of 30 %: a constant, although the targets vary.
#[test]
fn noisy_constant() {
    let cell = Cell::new(900, 0.3, |_| [1.0, 0.5, 2.0]);
    let fit = cell.fit(&smallest(0.05));
    assert_eq!(fit.model.shape.sizes, [0, 3]);
    assert_eq!(fit.end, FitEnd::Target);
    assert_eq!(cells::names(&fit.dropped_inputs), cells::INPUTS);
}

/// No architecture reaches 0.1 %: the best one is kept and the reason is not the target.
#[test]
fn out_of_reach() {
    let cell = Cell::new(600, 0.02, smooth);
    let fit = cell.fit(&TrainConfig {
        prune: None,
        ..smallest(0.001)
    });
    assert_ne!(fit.end, FitEnd::Target);
    assert!(fit.model.shape.sizes.len() == 4);
}
