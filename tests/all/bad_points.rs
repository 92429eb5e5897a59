//! Points tables that cannot be used: refused with file, column and row; no table is written.

use crate::program::{Place, cornell, refused, tiny_run};
use crate::table::{self, GEOMETRY, Table};

/// Ten good rows: the floor of the Cornell box, seen and lit from above.
fn columns() -> Vec<(&'static str, Vec<f32>)> {
    let row = [0.0, 0.0, 0.9, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.1, 1.6, 0.2];
    GEOMETRY.into_iter().zip(row.map(|x| vec![x; 10])).collect()
}

/// `rrf trace --points` and `rrf query` both refuse the table, and write none.
fn both_refuse(columns: &[(&str, Vec<f32>)], words: &[&str]) {
    let place = Place::new();
    let (input, out) = (place.name("in.parquet"), place.name("out.parquet"));
    table::write(&input, columns);
    let words = [&["in.parquet"], words].concat();
    refused(
        &[
            "trace",
            &cornell(),
            "--points",
            &input,
            "-o",
            &out,
            "--spp",
            "16",
        ],
        &words,
    );
    refused(
        &["query", &tiny_run(), "--points", &input, "-o", &out],
        &words,
    );
    assert!(place.holds(&["in.parquet"]), "something was written");
}

#[test]
fn good_rows_are_answered() {
    let place = Place::new();
    let (input, out) = (place.name("in.parquet"), place.name("out.parquet"));
    table::write(&input, &columns());
    let run = tiny_run();
    crate::program::done(&["query", &run, "--points", &input, "-o", &out]);
    assert_eq!(Table::read(&out).rows(), 10);
}

/// A name that is no light of the scene: the row and the names there are.
#[test]
fn light_unknown() {
    let place = Place::new();
    let (input, out) = (place.name("in.parquet"), place.name("out.parquet"));
    let mut lights = vec!["light0"; 10];
    lights[7] = "light00";
    table::write_lit(&input, &columns(), &lights);
    let trace = ["trace", &cornell(), "--points", &input, "-o", &out];
    let words = ["in.parquet", "row 7", "\"light00\"", "point, sun", "light0"];
    refused(&[&trace[..], &["--spp", "16"]].concat(), &words);
    assert!(place.holds(&["in.parquet"]), "something was written");
    lights[7] = "point";
    table::write_lit(&input, &columns(), &lights);
    crate::program::done(&[&trace[..], &["--spp", "16"]].concat());
    assert_eq!(Table::read(&out).rows(), 10);
}

#[test]
fn column_missing() {
    for missing in [0, 4, 11] {
        let mut columns = columns();
        let (name, _) = columns.remove(missing);
        both_refuse(&columns, &[name, "missing"]);
    }
}

#[test]
fn not_a_number() {
    for bad in [f32::NAN, f32::INFINITY] {
        let mut columns = columns();
        columns[9].1[6] = bad;
        both_refuse(&columns, &["lx", "row 6"]);
    }
}

#[test]
fn off_the_surface() {
    let mut columns = columns();
    columns[1].1[3] = 0.1;
    both_refuse(&columns, &["row 3", "no surface"]);
}

#[test]
fn viewer_below_the_surface() {
    let mut columns = columns();
    columns[7].1[2] = -1.0;
    both_refuse(&columns, &["vx", "row 2", "normal"]);
}

#[test]
fn normal_of_length_zero() {
    let mut columns = columns();
    columns[4].1[5] = 0.0;
    both_refuse(&columns, &["nx", "row 5"]);
}

#[test]
fn no_table_at_all() {
    let place = Place::new();
    let (run, out) = (tiny_run(), place.name("out.parquet"));
    let text = place.write("in.parquet", "px,py,pz\n0,0,0\n");
    let query = |input: &str, out: &str, words: &[&str]| {
        refused(&["query", &run, "--points", input, "-o", out], words);
        refused(
            &[
                "trace",
                &cornell(),
                "--points",
                input,
                "-o",
                out,
                "--spp",
                "16",
            ],
            words,
        );
    };
    query(&text, &out, &["in.parquet", "Parquet"]);
    query(
        &place.name("no.parquet"),
        &out,
        &["no.parquet", "No such file"],
    );
    query(
        &place.write("in.csv", ""),
        &out,
        &["in.csv", "unknown table format", ".parquet"],
    );
    query(
        &text,
        &place.name("out.csv"),
        &["out.csv", "unknown table format", ".parquet"],
    );
    assert!(place.holds(&["in.csv", "in.parquet"]));
}

/// An answer over its own question: the table is replaced whole or not at all.
#[test]
fn refused_tables_leave_the_old_one() {
    let place = Place::new();
    let input = place.name("in.parquet");
    let mut columns = columns();
    columns[1].1[3] = 0.1;
    table::write(&input, &columns);
    let out = place.write("out.parquet", "mine");
    refused(
        &["query", &tiny_run(), "--points", &input, "-o", &out],
        &["row 3"],
    );
    assert_eq!(std::fs::read(&out).expect("still there"), b"mine");
}
