//! Tables of points.

use crate::made;
use arrow::array::{
    ArrayRef, AsArray, BooleanArray, DictionaryArray, Float32Array, Float64Array, LargeStringArray,
    RecordBatch, StringArray, UInt32Array,
};
use arrow::datatypes::{Field, Float32Type, Int32Type, Schema};
use rrf_field::columns::{GEOMETRY, NAMES};
use rrf_store::Limits;
use rrf_store::StoreError;
use rrf_store::points::{read_points, write_points};
use rrf_store::schema::Table;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

fn column(c: usize, rows: u64) -> Float32Array {
    (0..rows).map(|r| Some(made::row(r)[c])).collect()
}

/// Geometry in reverse order among other columns, `changed` in the place of one.
fn batch(rows: u64, changed: Option<(&str, ArrayRef)>) -> RecordBatch {
    let mut columns: Vec<(String, ArrayRef)> = (0..GEOMETRY)
        .rev()
        .map(|c| (NAMES[c].to_string(), Arc::new(column(c, rows)) as ArrayRef))
        .collect();
    let names: StringArray = (0..rows).map(|r| Some(format!("wall {}", r % 3))).collect();
    columns.insert(5, ("material".into(), Arc::new(names)));
    columns.insert(2, ("r".into(), Arc::new(column(0, rows))));
    columns.push(("g_se".into(), Arc::new(column(1, rows))));
    if let Some((name, array)) = changed {
        columns.iter_mut().find(|(n, _)| n == name).unwrap().1 = array;
    }
    let batch = RecordBatch::try_from_iter(columns).unwrap();
    let schema = Schema::new_with_metadata(
        batch.schema().fields().clone(),
        [("by".to_string(), "somebody else".to_string())],
    );
    batch.with_schema(Arc::new(schema)).unwrap()
}

/// Written by arrow and parquet themselves, not by the code under test.
fn save(path: &Path, batch: &RecordBatch) {
    let file = std::fs::File::create(path).unwrap();
    if path.extension().unwrap() == "parquet" {
        let mut writer = parquet::arrow::ArrowWriter::try_new(file, batch.schema(), None).unwrap();
        writer.write(batch).unwrap();
        writer.close().unwrap();
    } else {
        let mut writer = arrow::ipc::writer::FileWriter::try_new(file, &batch.schema()).unwrap();
        writer.write(batch).unwrap();
        writer.finish().unwrap();
    }
}

fn answers(rows: usize) -> BTreeMap<&'static str, ArrayRef> {
    let rgb = Arc::new(Float32Array::from(vec![0.25; rows])) as ArrayRef;
    BTreeMap::from([
        ("r", rgb.clone()),
        ("g", rgb.clone()),
        ("b", rgb),
        ("cell_id", Arc::new(UInt32Array::from(vec![7; rows])) as _),
        (
            "trusted",
            Arc::new(BooleanArray::from(vec![true; rows])) as _,
        ),
    ])
}

#[test]
fn columns_in_any_order_and_others_kept() {
    let folder = tempfile::tempdir().unwrap();
    for (input, output) in [("in.parquet", "out.arrow"), ("in.arrow", "out.parquet")] {
        let (input, output) = (folder.path().join(input), folder.path().join(output));
        save(&input, &batch(100, None));
        let points = read_points(&input, Limits::default()).unwrap();
        for (c, values) in points.geometry.iter().enumerate() {
            let exact = column(c, 100);
            // n and v are scaled to unit length: one rounding each.
            let tolerance = if (3..9).contains(&c) {
                2.0 * f32::EPSILON
            } else {
                0.0
            };
            for (a, b) in values.iter().zip(exact.values()) {
                assert!((a - b).abs() <= tolerance * b.abs(), "{} {a} {b}", NAMES[c]);
            }
        }
        assert_eq!(points.rescaled_rows, 0);
        let facts = [("rrf.seed", "1".to_string())];
        write_points(&output, &points.batch, Table::Answers, answers(100), &facts).unwrap();
        let back = read_points(&output, Limits::default()).unwrap();
        let names: Vec<_> = back
            .batch
            .schema()
            .fields()
            .iter()
            .map(|f| f.name().clone())
            .collect();
        let mut wanted: Vec<&str> = NAMES[..GEOMETRY].iter().rev().copied().collect();
        wanted.insert(5, "material");
        wanted.extend(["r", "g", "b", "cell_id", "trusted"]);
        assert_eq!(names, wanted, "the stale r and g_se are gone");
        let red = back
            .batch
            .column_by_name("r")
            .unwrap()
            .as_primitive::<Float32Type>();
        assert!(red.values().iter().all(|&r| r == 0.25));
        let material = back.batch.column_by_name("material").unwrap();
        assert_eq!(
            material,
            batch(100, None).column_by_name("material").unwrap()
        );
        let schema = back.batch.schema();
        assert_eq!(schema.metadata().get("rrf.schema").unwrap(), "answers");
        assert_eq!(schema.metadata().get("rrf.seed").unwrap(), "1");
        assert!(
            !schema.metadata().contains_key("by"),
            "said of the old file"
        );
    }
}

#[test]
fn float64_is_rounded_to_nearest() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("in.parquet");
    // Halfway between two float32: to even, up to rounding; 0.1: nearest.
    let values = [0.1, 1.0 + f64::from(f32::EPSILON) / 2.0, 1e-50];
    let array = Arc::new(Float64Array::from(values.to_vec()));
    save(&path, &batch(3, Some(("lx", array))));
    let points = read_points(&path, Limits::default()).unwrap();
    assert_eq!(points.geometry[9], [0.1f32, 1.0, 0.0]);
}

#[test]
fn unusable_values_are_named_by_column_and_row() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("in.parquet");
    let float = |x: f32| Arc::new(Float32Array::from(vec![0.5, 0.5, x])) as ArrayRef;
    let cases: [(&str, ArrayRef, &str); 6] = [
        ("px", float(f32::NAN), "column px, row 2: not a finite"),
        ("ly", float(f32::INFINITY), "column ly, row 2: not a finite"),
        (
            "nz",
            Arc::new(Float32Array::from(vec![1.0, 0.0, 1.0])),
            "column nx, row 1: a direction of length zero",
        ),
        (
            "vz",
            Arc::new(Float32Array::from(vec![0.5, -0.5, 0.5])),
            "column vx, row 1: the viewer is below",
        ),
        (
            "lz",
            Arc::new(Float32Array::from(vec![Some(1.0), None, None])),
            "column lz, row 1: no value",
        ),
        (
            "pz",
            Arc::new(Float64Array::from(vec![0.0, 0.0, 1e300])),
            "column pz, row 2: not a finite",
        ),
    ];
    for (name, array, wanted) in cases {
        save(&path, &batch(3, Some((name, array))));
        let error = read_points(&path, Limits::default()).unwrap_err();
        assert!(error.to_string().contains(wanted), "{wanted}: {error}");
        assert!(error.is_bad_input());
    }
    let text = Arc::new(StringArray::from(vec!["a", "b", "c"])) as ArrayRef;
    save(&path, &batch(3, Some(("px", text))));
    let error = read_points(&path, Limits::default())
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("column px: expected float32 or float64, found Utf8"),
        "{error}"
    );
}

#[test]
fn missing_and_double_columns_and_other_endings() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("in.parquet");
    let whole = batch(3, None);
    let few: Vec<usize> = (0..8).collect();
    save(&path, &whole.project(&few).unwrap());
    let error = read_points(&path, Limits::default())
        .unwrap_err()
        .to_string();
    assert!(error.contains("missing: px py pz nx ny nz"), "{error}");
    let fields: Vec<Field> = (0..15).map(|i| whole.schema().field(i).clone()).collect();
    let mut fields = fields;
    fields[14] = fields[13].clone();
    let mut columns = whole.columns().to_vec();
    columns[14] = columns[13].clone();
    let double = RecordBatch::try_new(Arc::new(Schema::new(fields)), columns).unwrap();
    let path = folder.path().join("in.arrow");
    save(&path, &double);
    let error = read_points(&path, Limits::default())
        .unwrap_err()
        .to_string();
    assert!(error.contains("is there twice"), "{error}");
    let other = folder.path().join("in.csv");
    let error = read_points(&other, Limits::default()).unwrap_err();
    assert!(matches!(error, StoreError::UnknownFormat { .. }));
}

#[test]
fn long_normals_are_scaled_and_counted() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("in.arrow");
    let nz = Arc::new(Float32Array::from(vec![1.0, 2.0, 1e-20]));
    save(&path, &batch(3, Some(("nz", nz))));
    let points = read_points(&path, Limits::default()).unwrap();
    assert_eq!(points.geometry[5], [1.0; 3]);
    assert_eq!(points.rescaled_rows, 2);
}

/// Names of lights in any encoding; rows without one have the point; l is not read where an own
/// light shines.
#[test]
fn lights_are_named_row_by_row() {
    let folder = tempfile::tempdir().unwrap();
    let names = [Some("sky"), None, Some("sun"), Some("sky"), Some("point")];
    let plain: ArrayRef = Arc::new(StringArray::from(names.to_vec()));
    let kinds = [
        plain.clone(),
        Arc::new(LargeStringArray::from(names.to_vec())),
        Arc::new(names.into_iter().collect::<DictionaryArray<Int32Type>>()),
    ];
    let lx = [f32::NAN, 1.0, 2.0, f32::NAN, 3.0].map(|x| (!x.is_nan()).then_some(x));
    let lx: ArrayRef = Arc::new(Float32Array::from(lx.to_vec()));
    for (number, names) in kinds.into_iter().enumerate() {
        let path = folder.path().join(format!("{number}.arrow"));
        let batch = batch(5, Some(("lx", lx.clone())));
        let mut columns: Vec<(String, ArrayRef)> = (batch.schema().fields().iter())
            .zip(batch.columns())
            .map(|(field, column)| (field.name().clone(), column.clone()))
            .collect();
        columns.push(("light".into(), names));
        save(&path, &RecordBatch::try_from_iter(columns).unwrap());
        let points = read_points(&path, Limits::default()).unwrap();
        assert_eq!(points.light_names, ["point", "sky", "sun"]);
        assert_eq!(points.light, [1, 0, 2, 1, 0]);
        assert_eq!(points.geometry[9], [0.0, 1.0, 2.0, 0.0, 3.0]);
    }
    let path = folder.path().join("none.arrow");
    save(&path, &batch(2, None));
    let points = read_points(&path, Limits::default()).unwrap();
    assert_eq!((points.light_names.len(), points.light), (1, vec![0, 0]));
}
