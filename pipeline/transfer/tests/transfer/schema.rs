//! `patches.toml` describes what `Patches` holds.

/// Every column is described in full, and they are the columns that patches have.
#[test]
fn every_column_is_described() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/patches.toml");
    let text = std::fs::read_to_string(path).unwrap();
    let table: toml::Table = text.parse().unwrap();
    let columns = table["column"].as_array().unwrap();
    let name = |c: &toml::Value| c["name"].as_str().unwrap().to_string();
    let names: Vec<String> = columns.iter().map(name).collect();
    let expected = "patch_id area x y z nx ny nz object material directions first_column";
    assert_eq!(names.join(" "), expected);
    for column in columns {
        for key in ["type", "unit", "frame", "meaning"] {
            assert!(column[key].as_str().is_some_and(|text| !text.is_empty()));
        }
        assert!(column["nullable"].as_bool().is_some());
    }
}
