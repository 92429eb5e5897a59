//! The model's tables.

use crate::made;
use rrf_field::model::{CellModel, Kind, MODEL_KINDS};
use rrf_store::StoreError;
use rrf_store::layout::fit_folder;
use rrf_store::manifest::RunFacts;
use rrf_store::model::{
    ModelTree, read_metrics, read_model, read_steps, read_tree, read_weights, write_metrics,
    write_steps, write_tree, write_weights,
};

/// What the message must say, and the damage.
type Spoil<T> = (&'static str, fn(&mut T));

#[test]
fn model_is_read_back() {
    let run = tempfile::tempdir().unwrap();
    let facts = made::facts();
    let cells = [2, 0, 1].map(made::cell_model);
    write_tree(run.path(), &made::tree(), &facts).unwrap();
    write_weights(run.path(), &cells, &facts).unwrap();
    let model = read_model(run.path(), &facts).unwrap();
    assert_eq!(model.tree, made::tree());
    assert_eq!(model.cells, [0, 1, 2].map(made::cell_model));
    let metrics = [1, 0, 2].map(made::metrics);
    write_metrics(run.path(), &metrics, &facts).unwrap();
    let back = read_metrics(run.path(), &facts).unwrap();
    assert_eq!(back, [0, 1, 2].map(made::metrics));
}

#[test]
fn bytes_are_the_same_each_time() {
    let (a, b) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    for (run, order) in [(&a, [0, 1, 2]), (&b, [2, 1, 0])] {
        write_tree(run.path(), &made::tree(), &made::facts()).unwrap();
        write_weights(run.path(), &order.map(made::cell_model), &made::facts()).unwrap();
        write_metrics(run.path(), &order.map(made::metrics), &made::facts()).unwrap();
    }
    for name in ["tree", "weights", "metrics"] {
        let read = |run: &tempfile::TempDir| {
            std::fs::read(run.path().join(format!("model/{name}.arrow"))).unwrap()
        };
        assert_eq!(read(&a), read(&b), "{name}");
    }
}

#[test]
fn a_model_of_another_scene_is_refused() {
    let run = tempfile::tempdir().unwrap();
    write_tree(run.path(), &made::tree(), &made::facts()).unwrap();
    let other = RunFacts {
        scene_hash: "a".repeat(64),
        ..made::facts()
    };
    let error = read_tree(run.path(), &other).unwrap_err();
    assert!(matches!(error, StoreError::Foreign { .. }), "{error}");
}

#[test]
fn leaves_and_nets_must_match() {
    let run = tempfile::tempdir().unwrap();
    write_tree(run.path(), &made::tree(), &made::facts()).unwrap();
    for (cells, wanted) in [
        (vec![0, 2], "cell 1: no net"),
        (vec![0, 1, 2, 5], "cell 5: no leaf"),
    ] {
        let cells: Vec<_> = cells.into_iter().map(made::cell_model).collect();
        write_weights(run.path(), &cells, &made::facts()).unwrap();
        let text = read_model(run.path(), &made::facts())
            .unwrap_err()
            .to_string();
        assert!(text.contains(wanted), "{text}");
    }
}

/// Every way to spoil a tree is found, before it is written.
#[test]
fn trees_that_do_not_end_are_refused() {
    let run = tempfile::tempdir().unwrap();
    let spoil: [Spoil<ModelTree>; 10] = [
        ("left child 0", |t| t.tree.left[2] = 0),
        ("left child 1", |t| t.tree.left[2] = 1),
        ("left child 4294967295", |t| t.tree.left[2] = u32::MAX),
        ("threshold NaN", |t| t.tree.threshold[0] = f32::NAN),
        ("axis 18", |t| t.tree.axis[0] = 18),
        ("axis -2", |t| t.tree.axis[0] = -2),
        ("no leaf is cell 0", |t| t.tree.cell[1] = u32::MAX),
        ("no leaf is cell 0", |t| t.tree.cell[1] = 1),
        ("no earlier node's child", |t| {
            t.tree.axis[2] = -1;
            t.tree.cell[2] = 9;
        }),
        ("upside down", |t| {
            t.domains[1].as_mut().unwrap().minimum[3] = f32::INFINITY
        }),
    ];
    for (wanted, spoil) in spoil {
        let mut tree = made::tree();
        spoil(&mut tree);
        let error = write_tree(run.path(), &tree, &made::facts()).unwrap_err();
        assert!(matches!(error, StoreError::Model { .. }), "{error}");
        assert!(error.to_string().contains(wanted), "{wanted}: {error}");
    }
    assert!(!run.path().join("model/tree.arrow").exists());
}

#[test]
fn nets_of_wrong_lengths_are_refused() {
    let run = tempfile::tempdir().unwrap();
    let spoil: [Spoil<CellModel>; 7] = [
        ("weights", |m| m.weights.truncate(5)),
        ("not finite", |m| m.weights[3] = f32::INFINITY),
        ("offsets and scales", |m| m.input_scale.push(1.0)),
        ("layers", |m| m.shape.sizes = vec![13, 6, 4, 2]),
        ("layers", |m| m.shape.sizes = vec![13, 0, 4, 3]),
        ("more than can be", |m| {
            m.shape.sizes = vec![13, usize::MAX, usize::MAX, 3]
        }),
        ("not known", |m| m.inputs[0] = 200),
    ];
    for (wanted, spoil) in spoil {
        let mut cell = made::cell_model(0);
        spoil(&mut cell);
        let error = write_weights(run.path(), &[cell], &made::facts()).unwrap_err();
        assert!(error.to_string().contains(wanted), "{wanted}: {error}");
    }
    let twice = [made::cell_model(4), made::cell_model(4)];
    assert!(write_weights(run.path(), &twice, &made::facts()).is_err());
}

#[test]
fn read_weights_needs_a_file() {
    let run = tempfile::tempdir().unwrap();
    let error = read_weights(run.path(), &made::facts()).unwrap_err();
    assert!(
        matches!(error, StoreError::Io { .. }) && error.is_bad_input(),
        "{error}"
    );
}

#[test]
fn steps_are_read_back() {
    let run = tempfile::tempdir().unwrap();
    let fit = fit_folder(run.path(), 0, 1);
    assert_eq!(read_steps(&fit, &made::facts()).unwrap(), None);
    for steps in [made::steps(), Vec::new()] {
        write_steps(&fit, &steps, &made::facts()).unwrap();
        assert_eq!(read_steps(&fit, &made::facts()).unwrap(), Some(steps));
    }
    let mut other = made::facts();
    other.seed ^= 1;
    let refused = read_steps(&fit, &other).unwrap_err();
    assert!(refused.is_bad_input(), "{refused}");
}

/// Of whatever kind a model is, it is read back; what is stored of it has to be that kind's.
#[test]
fn models_of_every_kind() {
    let run = tempfile::tempdir().unwrap();
    let of = |kind: Kind| {
        let sizes = match kind {
            Kind::Net => vec![9, 2, 3],
            Kind::Quadratic => vec![9, 3],
            Kind::Nearest => vec![9, 4, 3],
            Kind::Probes => vec![9, 2, 2, 3],
        };
        CellModel {
            kind,
            inputs: (0..9).collect(),
            input_offset: vec![0.0; 9],
            input_scale: vec![1.0; 9],
            weights: vec![0.5; kind.weights(&sizes).unwrap()],
            shape: rrf_field::net::Shape { sizes },
            ..made::cell_model(0)
        }
    };
    for kind in MODEL_KINDS {
        write_weights(run.path(), &[of(kind)], &made::facts()).unwrap();
        let back = read_weights(run.path(), &made::facts()).unwrap();
        assert_eq!(back, [of(kind)]);
        for other in MODEL_KINDS.into_iter().filter(|other| *other != kind) {
            let wrong = CellModel {
                kind: other,
                ..of(kind)
            };
            let error = write_weights(run.path(), &[wrong], &made::facts()).unwrap_err();
            assert!(matches!(error, StoreError::Model { .. }), "{error}");
        }
    }
}
