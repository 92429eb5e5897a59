//! Ground truth at points: `rrf trace --points` against Mitsuba 3's tables.

use crate::judge::Oracle;
use crate::program::{Place, cornell, done, file, oracle};
use crate::table::Table;

/// `estimator` is the table's own where it misses light: next-event estimation rarely meets a light
/// that is millimetres from a surface, or one that a mirror shows (docs/science/report.md).
fn agrees(scene: &str, table: &str, estimator: &str, paths: &str) {
    let place = Place::new();
    let out = place.name("out.parquet");
    let input = oracle(table);
    let call = ["trace", scene, "--points", &input, "-o", &out];
    done(&[&call[..], &["--estimator", estimator, "--spp", paths]].concat());
    let found = Table::read(&out);
    let agreement = Oracle::read(&input).agreement(&found.rgb(""), &found.rgb("_se"));
    assert!(agreement.passes(), "{table}: {agreement:#?}");
}

#[test]
fn lights_overhead() {
    agrees(&cornell(), "cornell_overhead", "connected", "1024");
}

#[test]
fn lights_anywhere() {
    agrees(&cornell(), "cornell_free", "next-event", "1024");
}

/// Principled materials: rough and smooth, metals and dielectrics.
#[test]
fn glossy_materials() {
    let scene = file("scenes/cornell-glossy/cornell-glossy.glb");
    agrees(&scene, "cornell_glossy", "next-event", "4096");
}

/// The table comes back with its rows in order, its own columns first and untouched, and the
/// answers of another seed are other numbers.
#[test]
fn rows_and_columns_stay() {
    let place = Place::new();
    let input = oracle("cornell_overhead");
    let trace = |name: &str, seed: &str| {
        let out = place.name(name);
        let call = ["trace", &cornell(), "--points", &input, "-o", &out];
        done(&[&call[..], &["--spp", "16", "--seed", seed]].concat());
        Table::read(&out)
    };
    let (asked, a, b) = (
        Table::read(&input),
        trace("a.parquet", "1"),
        trace("b.parquet", "2"),
    );
    for name in crate::table::GEOMETRY {
        assert_eq!(asked.numbers(name), a.numbers(name), "{name}");
    }
    assert_eq!(asked.names("material"), a.names("material"));
    assert_ne!(a.rgb(""), b.rgb(""));
}
