//! Writes a small run and its tables, for checks by other programs:
//! `cargo run --release -p rrf-store --example fixture -- FOLDER`.
//!
//! FOLDER/run is a run folder with three cells, as an interrupted writer would leave it (an
//! unfinished part in `staging/`). FOLDER/queries.parquet is a points table, FOLDER/answers.parquet
//! and .arrow are the same rows answered by the nets in f64, FOLDER/truth.parquet has its columns
//! of path-traced radiance made up.

#[path = "../tests/tables/made.rs"]
mod made;

use arrow::array::{ArrayRef, BooleanArray, Float32Array, RecordBatch, UInt32Array};
use rrf_field::columns::Columns;
use rrf_field::inputs::fill;
use rrf_field::model::CellModel;
use rrf_store::layout::{fit_folder, staging_folder};
use rrf_store::model::{write_metrics, write_steps, write_tree, write_weights};
use rrf_store::parts::write_part;
use rrf_store::points::write_points;
use rrf_store::schema::Table;
use std::collections::BTreeMap;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::Arc;

const CELLS: [u32; 3] = [0, 1, 2];

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args_os().nth(1).map(PathBuf::from);
    let folder = folder.ok_or("usage: fixture FOLDER")?;
    let run = folder.join("run");
    made::manifest().write(&run)?;
    let facts = made::facts();
    for cell in CELLS {
        for part in 0..2 {
            let first = u64::from(cell) * 10_000 + u64::from(part) * 500;
            write_part(&run, part, &made::samples(cell, first, 500), &facts)?;
        }
    }
    std::fs::write(
        staging_folder(&run).join("cell=000002-part-00002.0.tmp"),
        b"PAR1",
    )?;
    write_tree(&run, &made::tree(), &facts)?;
    write_weights(&run, &CELLS.map(made::cell_model), &facts)?;
    write_metrics(&run, &CELLS.map(made::metrics), &facts)?;
    write_steps(&fit_folder(&run, 0, 0), &made::steps(), &facts)?;
    tables(&folder)
}

fn tables(folder: &Path) -> Result<(), Box<dyn Error>> {
    let samples = made::samples(0, 70_000, 200);
    let batch = samples.to_batch()?;
    let kept: Vec<usize> = (2..20).collect();
    let input = batch.project(&kept)?;
    let columns = &samples.columns;
    let tree = made::tree().tree;
    let cells = tree.find_all(columns);
    let mut rgb = vec![[0.0; 3]; columns.len()];
    for cell in CELLS {
        let answers = evaluate(&made::cell_model(cell), columns);
        for row in (0..columns.len()).filter(|&row| cells[row] == cell) {
            rgb[row] = answers[row];
        }
    }
    let channel = |c: usize| -> ArrayRef {
        Arc::new(
            rgb.iter()
                .map(|y| Some(y[c] as f32))
                .collect::<Float32Array>(),
        )
    };
    let trusted = BooleanArray::from(cells.iter().map(|&cell| cell != 2).collect::<Vec<_>>());
    let answers: BTreeMap<&str, ArrayRef> = BTreeMap::from([
        ("r", channel(0)),
        ("g", channel(1)),
        ("b", channel(2)),
        (
            "cell_id",
            Arc::new(UInt32Array::from(cells.clone())) as ArrayRef,
        ),
        ("trusted", Arc::new(trusted) as ArrayRef),
    ]);
    let truth: BTreeMap<&str, ArrayRef> = BTreeMap::from([
        ("r", channel(0)),
        ("g", channel(1)),
        ("b", channel(2)),
        ("r_se", channel(1)),
        ("g_se", channel(2)),
        ("b_se", channel(0)),
    ]);
    write_queries(&folder.join("queries.parquet"), &input)?;
    for name in ["answers.parquet", "answers.arrow"] {
        write_points(
            &folder.join(name),
            &input,
            Table::Answers,
            answers.clone(),
            &[],
        )?;
    }
    write_points(
        &folder.join("truth.parquet"),
        &input,
        Table::Truth,
        truth,
        &[],
    )?;
    Ok(())
}

fn write_queries(path: &Path, input: &RecordBatch) -> Result<(), Box<dyn Error>> {
    let file = std::fs::File::create(path)?;
    let mut writer = parquet::arrow::ArrowWriter::try_new(file, input.schema(), None)?;
    writer.write(input)?;
    writer.close()?;
    Ok(())
}

/// The model in f64 at every row: what a reader of `weights.arrow` has to arrive at.
fn evaluate(model: &CellModel, rows: &Columns) -> Vec<[f64; 3]> {
    let mut inputs = vec![Vec::new(); model.inputs.len()];
    for (input, values) in model.inputs.iter().zip(&mut inputs) {
        fill(*input, rows, values);
    }
    let weights: Vec<f64> = model.weights.iter().map(|&w| f64::from(w)).collect();
    let scaled = |row: usize| -> Vec<f64> {
        let scales = model.input_offset.iter().zip(&model.input_scale);
        let scaled = inputs
            .iter()
            .zip(scales)
            .map(|(values, (&offset, &scale))| {
                (f64::from(values[row]) - f64::from(offset)) * f64::from(scale)
            });
        scaled.collect()
    };
    let one = |row: usize| {
        let y = rrf_field::net::evaluate(&model.shape, &weights, &scaled(row));
        let base = rows.vec3(rrf_field::columns::BASE, row);
        std::array::from_fn(|c| {
            let y = if model.exponential {
                y[c].min(f64::from(rrf_field::MAX_EXPONENT)).exp()
            } else {
                y[c]
            };
            let y = y * f64::from(model.output_scale[c]) + f64::from(model.output_offset[c]);
            if model.divide_base {
                y * f64::from(base[c])
            } else {
                y
            }
        })
    };
    (0..rows.len()).map(one).collect()
}
