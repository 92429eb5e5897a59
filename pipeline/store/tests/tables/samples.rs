//! Parts of the samples dataset.

use crate::made;
use rrf_store::StoreError;
use rrf_store::layout::{list_cells, list_parts, part_path, samples_folder, staging_folder};
use rrf_store::manifest::RunFacts;
use rrf_store::part_reader::PartReader;
use rrf_store::parts::{encode_part, read_cell, read_part, write_part};
use rrf_store::samples::SampleTable;

#[test]
fn parts_are_read_back_in_order() {
    let run = tempfile::tempdir().unwrap();
    let (a, b) = (made::samples(42, 0, 1000), made::samples(42, 1000, 10));
    // Written in another order than read.
    write_part(run.path(), 1, &b, &made::facts()).unwrap();
    let info = write_part(run.path(), 0, &a, &made::facts()).unwrap();
    assert_eq!(
        info.path,
        run.path().join("samples/cell=000042/part-00000.parquet")
    );
    assert_eq!(
        info.hash,
        blake3::hash(&std::fs::read(&info.path).unwrap())
            .to_hex()
            .as_str()
    );
    assert_eq!(list_cells(run.path()).unwrap(), [42]);
    assert_eq!(list_parts(run.path(), 42).unwrap(), [0, 1]);
    assert_eq!(read_part(run.path(), 42, 0, &made::facts()).unwrap(), a);
    assert_eq!(read_part(run.path(), 42, 1, &made::facts()).unwrap(), b);
    let cell = read_cell(run.path(), 42, &made::facts()).unwrap();
    assert_eq!(cell.table, made::samples(42, 0, 1010));
    assert_eq!(cell.not_finite_rows, 0);
    assert_eq!(
        std::fs::read_dir(staging_folder(run.path()))
            .unwrap()
            .count(),
        0
    );
}

#[test]
fn bytes_depend_on_rows_place_and_facts_only() {
    let table = made::samples(7, 0, 500);
    let bytes = encode_part(3, &table, &made::facts()).unwrap();
    assert_eq!(bytes, encode_part(3, &table, &made::facts()).unwrap());
    assert_ne!(bytes, encode_part(4, &table, &made::facts()).unwrap());
    let other = RunFacts {
        seed: 5,
        ..made::facts()
    };
    assert_ne!(bytes, encode_part(3, &table, &other).unwrap());
}

#[test]
fn an_empty_part_and_several_row_groups() {
    let run = tempfile::tempdir().unwrap();
    let (empty, large) = (made::samples(0, 0, 0), made::samples(1, 0, 140_000));
    write_part(run.path(), 0, &empty, &made::facts()).unwrap();
    write_part(run.path(), 0, &large, &made::facts()).unwrap();
    assert_eq!(read_part(run.path(), 0, 0, &made::facts()).unwrap(), empty);
    assert_eq!(read_part(run.path(), 1, 0, &made::facts()).unwrap(), large);
    let path = part_path(run.path(), 1, 0);
    let reader = PartReader::open(&path, 1, 0, &made::facts()).unwrap();
    assert_eq!(reader.rows(), 140_000);
    let batches: Vec<_> = reader.map(Result::unwrap).collect();
    assert!(batches.len() >= 3 && batches.iter().all(|batch| batch.num_rows() <= 65_536));
}

#[test]
fn values_that_are_not_finite_are_kept_and_counted() {
    let run = tempfile::tempdir().unwrap();
    let mut table = made::samples(1, 0, 10);
    table.columns.columns[4][2] = f32::NAN;
    table.halves[1][2][0] = f32::NAN;
    table.halves[0][9][1] = f32::NEG_INFINITY;
    write_part(run.path(), 0, &table, &made::facts()).unwrap();
    let cell = read_cell(run.path(), 1, &made::facts()).unwrap();
    assert_eq!(cell.not_finite_rows, 2);
    assert!(cell.table.halves[1][2][0].is_nan());
    assert_eq!(cell.table.halves[0][9][1], f32::NEG_INFINITY);
}

#[test]
fn foreign_parts_are_refused_with_both_facts() {
    let run = tempfile::tempdir().unwrap();
    write_part(run.path(), 0, &made::samples(1, 0, 10), &made::facts()).unwrap();
    let scene = RunFacts {
        scene_hash: "f".repeat(64),
        ..made::facts()
    };
    let text = read_cell(run.path(), 1, &scene).unwrap_err().to_string();
    assert!(
        text.contains(&"f".repeat(64)) && text.contains(&made::facts().scene_hash),
        "{text}"
    );
    let seed = RunFacts {
        seed: 9,
        ..made::facts()
    };
    let error = read_cell(run.path(), 1, &seed).unwrap_err();
    assert!(
        matches!(error, StoreError::Foreign { fact: "seed", .. }),
        "{error}"
    );
    // A part copied into another cell's folder, and one renumbered.
    let from = part_path(run.path(), 1, 0);
    for (cell, part, fact) in [(2, 0, "cell"), (1, 1, "part")] {
        let to = part_path(run.path(), cell, part);
        std::fs::create_dir_all(to.parent().unwrap()).unwrap();
        std::fs::copy(&from, &to).unwrap();
        let error = read_part(run.path(), cell, part, &made::facts()).unwrap_err();
        assert!(
            matches!(error, StoreError::Foreign { fact: f, .. } if f == fact),
            "{error}"
        );
        assert!(error.is_bad_input());
    }
}

#[test]
fn strays_and_missing_cells_are_named() {
    let run = tempfile::tempdir().unwrap();
    let error = read_cell(run.path(), 3, &made::facts()).unwrap_err();
    assert!(matches!(error, StoreError::NoSamples { .. }), "{error}");
    write_part(run.path(), 0, &made::samples(1, 0, 1), &made::facts()).unwrap();
    let samples = samples_folder(run.path());
    std::fs::write(samples.join("cell=000001/part-1.parquet"), "").unwrap();
    let error = read_cell(run.path(), 1, &made::facts()).unwrap_err();
    assert!(error.to_string().contains("part-1.parquet"), "{error}");
    std::fs::create_dir(samples.join("cell=1")).unwrap();
    assert!(matches!(
        list_cells(run.path()),
        Err(StoreError::Stray { .. })
    ));
}

#[test]
fn columns_of_differing_length_are_refused() {
    let mut table = made::samples(1, 0, 10);
    table.paths.pop();
    let error = encode_part(0, &table, &made::facts()).unwrap_err();
    assert!(matches!(error, StoreError::Columns { .. }), "{error}");
    let none = SampleTable::default();
    assert!(encode_part(0, &none, &made::facts()).is_ok());
}
