//! Cells of all kinds in one field: each row gets its own cell's answer, under its own light and under
//! many; damaged ones are refused.

#![allow(clippy::unwrap_used)]

mod common;

use common::{Numbers, model, rows, tree};
use rrf_field::columns::L;
use rrf_field::model::{CellModel, Kind};
use rrf_field::net::Shape;
use rrf_field::tree::Tree;
use rrf_field::{Field, FieldError, Light};

/// A model with random weights.
fn of_kind(cell: u32, kind: Kind, numbers: &mut Numbers) -> CellModel {
    let (inputs, sizes) = match kind {
        Kind::Net => return model(cell, &[0, 1, 9, 18], &[5], numbers),
        Kind::Quadratic => (vec![0, 4, 9, 21], vec![4, 3]),
        Kind::Nearest => (vec![0, 1, 2, 9, 10], vec![5, 60, 3]),
        Kind::Probes => (vec![0, 1, 2, 3, 4, 5, 9, 10, 11], vec![9, 3, 2, 3]),
    };
    let count = kind.weights(&sizes).unwrap();
    CellModel {
        input_offset: inputs.iter().map(|_| 0.2 * numbers.next()).collect(),
        input_scale: inputs.iter().map(|_| 1.5 + numbers.next()).collect(),
        inputs,
        kind,
        shape: Shape { sizes },
        weights: (0..count).map(|_| numbers.next()).collect(),
        exponential: false,
        ..model(cell, &[], &[], numbers)
    }
}

const EACH: [Kind; 4] = [Kind::Net, Kind::Quadratic, Kind::Nearest, Kind::Probes];

fn mixed(cells: u32) -> Vec<CellModel> {
    let mut numbers = Numbers::new(4);
    (0..cells)
        .map(|c| of_kind(c, EACH[c as usize % 4], &mut numbers))
        .collect()
}

#[test]
fn each_row_gets_the_answer_of_its_cell() {
    let (tree, models) = (tree(12, 3), mixed(12));
    let field = Field::new(tree.clone(), models.clone()).unwrap();
    let rows = rows(2500, 5);
    let (mut out, mut cells) = Default::default();
    field.evaluate(&rows, &mut out, &mut cells).unwrap();
    assert_eq!(cells, tree.find_all(&rows));
    for (cell, model) in models.into_iter().enumerate() {
        let ids: Vec<u32> = (0..2500)
            .filter(|&r| cells[r as usize] as usize == cell)
            .collect();
        let alone = Field::new(Tree::single(), vec![CellModel { cell: 0, ..model }]).unwrap();
        let (mut wanted, mut zeros) = Default::default();
        alone
            .evaluate(&rows.take(&ids), &mut wanted, &mut zeros)
            .unwrap();
        for (out, wanted) in out.iter().zip(&wanted) {
            for (&id, wanted) in ids.iter().zip(wanted) {
                assert_eq!(out[id as usize].to_bits(), wanted.to_bits());
            }
        }
    }
}

/// s+ = Σ c_k Φ(…, l_k): one light after another, each put into the rows.
#[test]
fn many_lights_are_their_sum() {
    let field = Field::new(tree(12, 3), mixed(12)).unwrap();
    let rows = rows(700, 6);
    let mut numbers = Numbers::new(8);
    let mut three = || std::array::from_fn(|_| numbers.next());
    let lights: Vec<Light> = (0..3)
        .map(|_| Light {
            position: three(),
            intensity: three(),
        })
        .collect();
    let (mut found, mut cells) = Default::default();
    field
        .evaluate_lights(&rows, &lights, &mut found, &mut cells)
        .unwrap();
    let mut wanted = [(); 3].map(|()| vec![[0.0f64; 2]; rows.len()]);
    for light in &lights {
        let mut moved = rows.clone();
        for (axis, x) in light.position.into_iter().enumerate() {
            moved.columns[L + axis].fill(x);
        }
        let (mut out, mut cells) = Default::default();
        field.evaluate(&moved, &mut out, &mut cells).unwrap();
        for (c, wanted) in wanted.iter_mut().enumerate() {
            for (wanted, y) in wanted.iter_mut().zip(&out[c]) {
                let term = f64::from(light.intensity[c]) * f64::from(*y);
                *wanted = [wanted[0] + term, wanted[1] + term.abs() + 1.0];
            }
        }
    }
    for (found, wanted) in found.iter().zip(&wanted) {
        for (found, [wanted, size]) in found.iter().zip(wanted) {
            // nets begin from biases with the light worked in: roundings of sums of some tens of terms
            assert!(
                (f64::from(*found) - wanted).abs() < 1e-5 * size,
                "{found} {wanted}"
            );
        }
    }
}

#[test]
fn damaged_ones_are_refused() {
    type Damage = fn(&mut CellModel);
    let damages: [(&str, Damage); 7] = [
        ("7 weights, layers", |m| m.weights.truncate(7)),
        ("offsets and scales for layers", |m| m.shape.sizes = vec![3]),
        ("of kind", |m| m.shape.sizes[1..].fill(usize::MAX)),
        ("offsets and scales for layers", |m| m.input_scale.clear()),
        ("input 25 is not known", |m| m.inputs[1] = 25),
        ("exponents", |m| m.exponential = true),
        ("not finite", |m| m.weights[5] = f32::NAN),
    ];
    for kind in &EACH[1..] {
        for (reason, damage) in damages {
            let mut damaged = of_kind(0, *kind, &mut Numbers::new(2));
            assert!(Field::new(Tree::single(), vec![damaged.clone()]).is_ok());
            damage(&mut damaged);
            let refused = Field::new(Tree::single(), vec![damaged]).unwrap_err();
            assert!(matches!(refused, FieldError::Model { cell: 0, .. }));
            assert!(refused.to_string().contains(reason), "{kind:?}: {refused}");
        }
    }
    assert_eq!(Kind::Nearest.weights(&[4, 0, 3]), None);
    assert_eq!(Kind::Probes.weights(&[9, 1, 4, 3]), None);
}
