//! Damaged trees, models and batches are refused by name.

mod common;

use common::{Numbers, model, rows, tree};
use rrf_field::model::CellModel;
use rrf_field::tree::Tree;
use rrf_field::{Field, FieldError};

fn models(cells: u32) -> Vec<CellModel> {
    let mut numbers = Numbers::new(1);
    (0..cells)
        .map(|c| model(c, &[0, 1, 2], &[4], &mut numbers))
        .collect()
}

#[test]
fn a_damaged_tree_is_refused() {
    type Damage = fn(&mut Tree);
    let damages: [Damage; 11] = [
        |t| t.axis.clear(),
        |t| t.cell.truncate(3),
        |t| t.axis[0] = 18,
        |t| t.axis[0] = -7,
        |t| t.threshold[0] = f32::NAN,
        |t| t.left[0] = 0,
        |t| t.left[0] = u32::MAX,
        // found by fuzzing: boxes were made for four billion cells
        |t| t.cell[0] = 4_289_934_590,
        |t| t.left[1] = t.left[0],
        |t| t.cell.fill(0),
        |t| t.axis[0] = -1,
    ];
    for (i, damage) in damages.into_iter().enumerate() {
        // Nodes 0 and 1 are inner nodes: split the root, then its left child.
        let mut tree = Tree::single();
        let [left, _] = tree.split(0, 0, 0.0, 1);
        tree.split(left, 1, 0.0, 2);
        assert!(Field::new(tree.clone(), models(3)).is_ok());
        damage(&mut tree);
        let refused = Field::new(tree, models(3)).unwrap_err();
        assert!(
            matches!(refused, FieldError::Tree { .. } | FieldError::Count { .. }),
            "damage {i}: {refused}"
        );
    }
}

#[test]
fn a_damaged_model_is_refused() {
    type Damage = fn(&mut CellModel);
    let damages: [(&str, Damage); 10] = [
        ("another cell", |m| m.cell = 0),
        ("are not inputs, hidden units, 3", |m| {
            m.shape.sizes = vec![3, 0, 3]
        }),
        ("are not inputs, hidden units, 3", |m| {
            m.shape.sizes = vec![3]
        }),
        ("are not inputs, hidden units, 3", |m| {
            m.shape.sizes = vec![3, 4, 2]
        }),
        ("inputs, offsets and scales for layers", |m| {
            m.inputs.push(4)
        }),
        ("input 25 is not known", |m| m.inputs[1] = 25),
        ("inputs, offsets and scales for layers", |m| {
            m.input_scale.clear()
        }),
        ("weights, layers [3, 4, 3] of kind net have", |m| {
            m.weights.push(0.0)
        }),
        ("not finite", |m| m.weights[5] = f32::NAN),
        ("not finite", |m| m.output_scale[2] = f32::INFINITY),
    ];
    for (reason, damage) in damages {
        let mut models = models(2);
        damage(&mut models[1]);
        let refused = Field::new(tree(2, 1), models).unwrap_err();
        assert!(matches!(refused, FieldError::Model { cell: 1, .. }));
        assert!(refused.to_string().contains(reason), "{refused}");
    }
}

#[test]
fn counts_and_lengths_must_agree() {
    let refused = Field::new(tree(3, 1), models(2)).unwrap_err();
    assert_eq!(
        refused,
        FieldError::Count {
            cells: 3,
            models: 2
        }
    );

    let field = Field::new(tree(3, 1), models(3)).unwrap();
    let mut rows = rows(10, 1);
    rows.columns[4].pop();
    let (mut out, mut cells) = Default::default();
    let refused = field.evaluate(&rows, &mut out, &mut cells).unwrap_err();
    assert_eq!(
        refused,
        FieldError::Ragged {
            column: "ny",
            expected: 10,
            found: 9
        }
    );
}
