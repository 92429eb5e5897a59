//! The contract itself.

use rrf_field::columns::{COUNT, GEOMETRY, NAMES};
use rrf_store::schema::{Column, TABLES, Table, table};

/// Version of each table and what its columns hashed to when it was given that version.
const PINNED: [(Table, u32, &str); 15] = [
    (Table::Samples, 1, "1ef54b601e453216"),
    (Table::Tree, 1, "f207d34842db00d3"),
    (Table::Weights, 3, "61af74b0712c890f"),
    (Table::Metrics, 2, "468cb68439e4aa5a"),
    (Table::Points, 1, "4cd9cd184fdab6a7"),
    (Table::Truth, 1, "57d96e5160c35bbc"),
    (Table::Answers, 1, "9d8867ae3a9e58f3"),
    (Table::Tasks, 2, "1e13a503b7a07b05"),
    (Table::Results, 2, "2f45c5be5c2d66bb"),
    (Table::Steps, 1, "8955d1acd068e87a"),
    (Table::Transfer, 2, "88452d268edb66f6"),
    (Table::TransferTree, 1, "eec084312dd4bf6f"),
    (Table::TransferCells, 2, "9ad9875cdf870766"),
    (Table::TransferParts, 2, "a0f6115d3422414f"),
    (Table::TransferProgress, 1, "91aebb63cd09f5bb"),
];

/// Names, types, units and frames are what files promise: whoever changes one gives the table
/// a new version, so that old files are refused and not misread.
#[test]
fn columns_change_with_the_version_only() {
    let changed: Vec<String> = PINNED
        .iter()
        .filter_map(|&(name, version, pinned)| {
            let schema = table(name).unwrap();
            let found = pin(&schema.columns);
            ((schema.version, found.as_str()) != (version, pinned))
                .then(|| format!("(Table::{name:?}, {}, {found:?})", schema.version))
        })
        .collect();
    assert!(
        changed.is_empty(),
        "raise the version in schemas/, then pin: {changed:#?}"
    );
}

/// Sixteen digits of a hash of every column's name, type, unit, frame and nullability.
fn pin(columns: &[Column]) -> String {
    let mut hash = blake3::Hasher::new();
    for c in columns {
        let nullable = if c.nullable { "null" } else { "" };
        for text in [&c.name, &c.type_name, &c.unit, &c.frame, nullable] {
            hash.update(text.as_bytes()).update(b"\n");
        }
    }
    hash.finalize().to_hex()[..16].to_string()
}

/// The pin sees the unit of every column of every table: one that is changed alone changes it.
#[test]
fn a_changed_unit_is_seen() {
    for (name, _, pinned) in PINNED {
        let columns = &table(name).unwrap().columns;
        assert!(!columns.is_empty(), "{name:?}");
        for place in 0..columns.len() {
            let mut changed = columns.clone();
            changed[place].unit += "/s";
            let column = &columns[place].name;
            assert_ne!(pin(&changed), pinned, "{name:?}: {column}");
        }
    }
}

#[test]
fn every_table_is_listed_in_order() {
    for (i, name) in TABLES.into_iter().enumerate() {
        assert_eq!((name as usize, PINNED[i].0), (i, name));
        let schema = table(name).unwrap();
        assert_eq!(schema.table, name);
        let metadata = schema.arrow.metadata();
        assert_eq!(metadata.get("rrf.schema").unwrap(), name.name());
        for (column, field) in schema.columns.iter().zip(schema.arrow.fields()) {
            assert_eq!(field.metadata().get("unit").unwrap(), &column.unit);
            assert_eq!(field.metadata().get("frame").unwrap(), &column.frame);
            assert_eq!(field.metadata().get("meaning").unwrap(), &column.meaning);
        }
    }
}

/// The raw columns of the field are those of the schemas, in order and under the same names.
#[test]
fn raw_columns_are_the_fields() {
    let names = |name, skip, count| -> Vec<&str> {
        let columns = table(name).unwrap().columns.iter();
        columns
            .skip(skip)
            .take(count)
            .map(|c| c.name.as_str())
            .collect()
    };
    assert_eq!(names(Table::Samples, 2, COUNT), NAMES);
    assert_eq!(names(Table::Points, 0, 99), NAMES[..GEOMETRY]);
    assert_eq!(names(Table::Truth, 0, GEOMETRY), NAMES[..GEOMETRY]);
    assert_eq!(
        names(Table::Truth, GEOMETRY, 99),
        ["r", "g", "b", "r_se", "g_se", "b_se"]
    );
    assert_eq!(
        names(Table::Answers, GEOMETRY, 99),
        ["r", "g", "b", "cell_id", "trusted"]
    );
}
