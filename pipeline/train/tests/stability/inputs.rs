//! Inputs that are constant, zero, or of outlandish scale.

use crate::cells::{self, Cell, smooth};

#[test]
fn constant_and_zero_inputs_are_dropped_and_named() {
    let mut cell = Cell::new(600, 0.0, smooth);
    cell.column("vx").fill(0.0);
    cell.column("vy").fill(0.25);
    // what f32 makes of a plane's coordinate
    let wobble = |i: usize| 1.0 + f32::EPSILON * (i % 3) as f32;
    *cell.column("vz") = (0..600).map(wobble).collect();
    let fit = cell.fit(&cells::config());
    assert_eq!(cells::names(&fit.dropped_inputs), ["vx", "vy", "vz"]);
    assert_eq!(
        cells::names(&fit.model.inputs),
        ["px", "py", "lx", "ly", "lz"]
    );
    assert!(cell.error(&fit.model, smooth) < 0.1 * cells::of_the_mean(&cell));
}

/// In a Lambertian cell two rows of three thousand that lie elsewhere teach nothing about elsewhere; thirty do.
#[test]
fn an_input_of_a_few_odd_rows_is_dropped() {
    for (odd, lambert, dropped) in [(2, true, true), (2, false, false), (30, true, false)] {
        let mut cell = Cell::new(3000, 0.02, smooth);
        let turned = |i: usize| if i % (3000 / odd) == 7 { 0.0 } else { 1.0 };
        *cell.column("pz") = (0..3000).map(turned).collect();
        for base in ["base_r", "base_g", "base_b"] {
            cell.column(base).fill(1.0);
        }
        let mut config = cells::config();
        config.inputs.push("pz".into());
        config.divide_base = lambert;
        let fit = cell.fit(&config);
        let names = cells::names(&fit.dropped_inputs);
        assert_eq!(names.contains(&"pz"), dropped, "{odd}: {names:?}");
    }
}

/// Two planes that meet, and the two sides of one: where the place tells the normal, a cell that is to do without it does.
#[test]
fn a_normal_that_the_place_tells_is_dropped() {
    for (sides, by_place, dropped) in [
        (false, true, true),
        (false, false, false),
        (true, true, false),
    ] {
        let mut cell = Cell::new(3000, 0.02, smooth);
        let first: Vec<bool> = match sides {
            true => (0..3000).map(|i| i % 2 == 0).collect(),
            false => cell.column("px").iter().map(|x| *x < 0.0).collect(),
        };
        let along = |on: bool| {
            first
                .iter()
                .map(|f| f32::from(*f == on))
                .collect::<Vec<f32>>()
        };
        (*cell.column("nx"), *cell.column("nz")) = (along(true), along(false));
        let folded = cell.column("px").clone();
        if !sides {
            // the part of negative x stands upright
            *cell.column("pz") = folded.iter().map(|x| (-x).max(0.0)).collect();
            cell.column("px").iter_mut().for_each(|x| *x = x.max(0.0));
        }
        let mut config = cells::config();
        config.inputs.extend(["pz", "nx", "nz"].map(String::from));
        config.drop_redundant = by_place;
        let fit = cell.fit(&config);
        let names = cells::names(&fit.dropped_inputs);
        assert_eq!(
            names.contains(&"nx"),
            dropped,
            "{sides}, {by_place}: {names:?}"
        );
    }
}

/// 2^40 = 1.1e12, a power of two: the scaled inputs are the same numbers, so is the net.
/// (A vector's coordinates go together: beside one of 1e12 another of 1 counts as rounding.)
#[test]
fn inputs_scaled_by_1e12_change_nothing() {
    let mut cell = Cell::new(600, 0.0, smooth);
    let plain = cell.fit(&cells::config());
    for (name, power) in [
        ("px", 40),
        ("py", 40),
        ("lx", -40),
        ("ly", -40),
        ("lz", -40),
    ] {
        cell.column(name)
            .iter_mut()
            .for_each(|x| *x *= 2f32.powi(power));
    }
    let scaled = cell.fit(&cells::config());
    assert_eq!(plain.model.weights, scaled.model.weights);
    assert_eq!(plain.validation_error, scaled.validation_error);
}

/// Equal columns make JᵀJ singular; damping and decay share the weight out between them.
#[test]
fn duplicated_inputs_do_no_harm() {
    let mut cell = Cell::new(600, 0.0, smooth);
    *cell.column("vx") = cell.column("px").clone();
    *cell.column("vy") = cell.column("px").clone();
    let fit = cell.fit(&cells::config());
    assert!(cell.error(&fit.model, smooth) < 0.1 * cells::of_the_mean(&cell));
}
