//! What each option of the trainer brings: error against CPU seconds on the cells of a run.
//!
//! ```text
//! python3 tests/peers/export_cells.py RUN FOLDER CELLS
//! cargo run --release -p rrf-train --example options -- FOLDER [NAME...]
//! ```
//!
//! fits the exported cells under each set of options whose name contains one of the NAMEs (all
//! sets without a NAME) and prints one line a set: the root mean square of the cells' relative
//! errors on the rows held out, the CPU seconds of all fits, accepted steps and weights a cell.

mod sets;

use rrf_field::columns::{COUNT, Columns};
use rrf_sampling::{Stage, Stream};
use rrf_train::{CellFit, TrainConfig, fit_cell};
use std::error::Error;
use std::path::Path;

/// One cell's samples.
#[derive(Default)]
struct Table {
    columns: Columns,
    halves: [Vec<[f32; 3]>; 2],
}

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [folder, names @ ..] = args.as_slice() else {
        return Err("usage: options FOLDER [NAME...]".into());
    };
    let tables = read(Path::new(folder))?;
    let rows: usize = tables.iter().map(|table| table.columns.len()).sum();
    println!("{} cells, {rows} rows", tables.len());
    println!(
        "{:<24} {:>8} {:>8} {:>8} {:>8} {:>8}",
        "options", "error %", "± %", "CPU s", "steps", "weights"
    );
    let mean = mean_radiance(&tables);
    for (name, config) in sets::all() {
        if !names.is_empty() && !names.iter().any(|part| name.contains(part.as_str())) {
            continue;
        }
        let config = TrainConfig {
            divide_base: true,
            mean_radiance: Some(mean),
            ..config
        };
        let before = cpu_seconds();
        let fits = tables
            .iter()
            .zip(0..)
            .map(|(table, cell)| fit(cell, table, &config));
        let fits = fits.collect::<Result<Vec<_>, _>>()?;
        report(name, &fits, cpu_seconds() - before);
    }
    Ok(())
}

/// Cells as `tests/peers/export_cells.py` writes them: rows of 18 raw columns and two half
/// estimates, little-endian f32.
fn read(folder: &Path) -> Result<Vec<Table>, Box<dyn Error>> {
    let entries = std::fs::read_dir(folder)?.collect::<Result<Vec<_>, _>>()?;
    let mut paths: Vec<_> = entries.into_iter().map(|entry| entry.path()).collect();
    paths.retain(|path| path.extension().is_some_and(|e| e == "f32"));
    paths.sort();
    paths
        .iter()
        .map(|path| Ok(table(&std::fs::read(path)?)))
        .collect()
}

fn table(bytes: &[u8]) -> Table {
    let mut table = Table::default();
    let (values, _) = bytes.as_chunks::<4>();
    let values: Vec<f32> = values.iter().map(|b| f32::from_le_bytes(*b)).collect();
    for row in values.chunks_exact(COUNT + 6) {
        let (raw, halves) = row.split_at(COUNT);
        for (column, value) in table.columns.columns.iter_mut().zip(raw) {
            column.push(*value);
        }
        table.halves[0].push([halves[0], halves[1], halves[2]]);
        table.halves[1].push([halves[3], halves[4], halves[5]]);
    }
    table
}

/// Three rows in ten are held out.
fn fit(cell: u32, table: &Table, config: &TrainConfig) -> Result<CellFit, Box<dyn Error>> {
    let stream = Stream::new(1, Stage::Test, cell);
    let rows = 0..table.columns.len() as u64;
    let held_out: Vec<bool> = rows.map(|i| stream.f64(i, 0) < 0.3).collect();
    let halves = [table.halves[0].as_slice(), table.halves[1].as_slice()];
    Ok(fit_cell(cell, &table.columns, halves, &held_out, config)?)
}

fn mean_radiance(tables: &[Table]) -> f32 {
    let rows = || {
        tables
            .iter()
            .flat_map(|table| table.halves.iter().flatten())
    };
    let sum: f64 = rows().map(|y| f64::from(y[0] + y[1] + y[2]) / 3.0).sum();
    (sum / rows().count().max(1) as f64) as f32
}

fn report(name: &str, fits: &[CellFit], seconds: f64) {
    let n = fits.len() as f64;
    let square = fits.iter().map(|f| f.validation_error.square).sum::<f64>() / n;
    let variance: f64 = fits
        .iter()
        .map(|f| f.validation_error.square_se.powi(2))
        .sum();
    let error = square.max(0.0).sqrt();
    let steps: usize = fits.iter().map(|f| f.history.len()).sum();
    let weights: usize = fits.iter().map(|f| f.model.weights.len()).sum();
    println!(
        "{name:<24} {:>8.2} {:>8.2} {seconds:>8.2} {:>8.1} {:>8.0}",
        100.0 * error,
        100.0 * variance.sqrt() / n / (2.0 * error),
        steps as f64 / n,
        weights as f64 / n,
    );
}

/// CPU seconds of this process so far.
fn cpu_seconds() -> f64 {
    let mut time = libc::timespec {
        tv_sec: 0,
        tv_nsec: 0,
    };
    // SAFETY: the call fills the struct that it is given.
    unsafe { libc::clock_gettime(libc::CLOCK_PROCESS_CPUTIME_ID, &raw mut time) };
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}
