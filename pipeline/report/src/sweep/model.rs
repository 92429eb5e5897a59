//! The columns of a sweep's row that a run's folder tells.

use super::grid::Setting;
use super::results::SweepRow;
use crate::ReportError;
use rrf_bake::settings::Method;
use rrf_bake::{Run, RunMethod, TransferRun};
use rrf_metrics::estimate::SquareError;
use rrf_store::model::{self, TRANSFER_TABLES, model_table_path};
use rrf_store::schema::Table;
use std::path::Path;

/// The columns of a run's row that its folder tells.
pub(super) fn model_row(folder: &Path, setting: &Setting) -> Result<SweepRow, ReportError> {
    let row = match RunMethod::of(folder)? {
        RunMethod::Nets => of_nets(folder)?,
        RunMethod::Transfer => of_transfer(folder)?,
    };
    let method = setting.0.get("method").cloned();
    Ok(SweepRow {
        method: method.unwrap_or_else(|| Method::default().name()),
        ..row
    })
}

fn of_nets(folder: &Path) -> Result<SweepRow, ReportError> {
    let run = Run::open(folder)?;
    let metrics = model::read_metrics(folder, &run.facts())?;
    let (mut count, mut square, mut variance) = (0.0, 0.0, 0.0);
    for cell in &metrics {
        if let Some(error) = cell.validation {
            let n = cell.validation_rows as f64;
            count += n;
            square += n * error.mean;
            variance += (n * error.se).powi(2);
        }
    }
    let whole = (count > 0.0).then(|| {
        let (mean, se) = (square / count, variance.sqrt() / count);
        SquareError { mean, se }.relative()
    });
    let config = &run.manifest.config;
    Ok(SweepRow {
        preset: config["preset"].as_str().map(str::to_string),
        rows: Some(metrics.iter().map(|cell| cell.rows).sum()),
        paths: config["extract"]["paths"].as_u64(),
        cells: Some(metrics.len() as u64),
        weights: Some(metrics.iter().map(|cell| u64::from(cell.weights)).sum()),
        target: config["target"].as_f64(),
        model_bytes: Some(bytes(folder, &[Table::Tree, Table::Weights])?),
        held_out_error: whole.map(|whole| whole.0),
        held_out_error_se: whole.map(|whole| whole.1),
        ..SweepRow::default()
    })
}

fn of_transfer(folder: &Path) -> Result<SweepRow, ReportError> {
    let run = TransferRun::open(folder)?;
    let summary = run.summary(&run.load_scene()?.unlit())?;
    let config = &run.manifest.config;
    Ok(SweepRow {
        preset: config["preset"].as_str().map(str::to_string),
        rows: Some(summary.rows),
        paths: Some(run.config.paths.into()),
        cells: Some(summary.cells as u64),
        target: config["target"].as_f64(),
        model_bytes: Some(bytes(folder, &TRANSFER_TABLES)?),
        held_out_error: Some(summary.held_out_error),
        held_out_error_se: Some(summary.held_out_error_se),
        ..SweepRow::default()
    })
}

fn bytes(folder: &Path, tables: &[Table]) -> Result<u64, ReportError> {
    let mut sum = 0;
    for &table in tables {
        let path = model_table_path(folder, table);
        let meta = std::fs::metadata(&path).map_err(|e| ReportError::file(&path, "be read", e))?;
        sum += meta.len();
    }
    Ok(sum)
}
