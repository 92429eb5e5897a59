//! Reads a points table and writes it again with radiance 0 appended, as `rrf trace --points`
//! would with its own: `cargo run --release -p rrf-store --example echo_points -- IN OUT`.
//! Other programs' tables go through this in the Python checks.

use arrow::array::{ArrayRef, Float32Array};
use rrf_store::Limits;
use rrf_store::points::{check_ending, read_points, write_points};
use rrf_store::schema::{Table, table};
use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

fn main() -> ExitCode {
    match echo() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn echo() -> Result<(), Box<dyn Error>> {
    let mut paths = std::env::args_os().skip(1).map(PathBuf::from);
    let (Some(input), Some(output)) = (paths.next(), paths.next()) else {
        return Err("usage: echo_points IN OUT".into());
    };
    check_ending(&output)?;
    let points = read_points(&input, Limits::default())?;
    let zeros: ArrayRef = Arc::new(Float32Array::from(vec![0.0; points.len()]));
    let added = table(Table::Truth)?.own();
    let added = added
        .map(|field| (field.name().as_str(), zeros.clone()))
        .collect();
    write_points(&output, &points.batch, Table::Truth, added, &[])?;
    println!("{} rows, {} rescaled", points.len(), points.rescaled_rows);
    Ok(())
}
