//! From a path to tables.

use super::tables::{Result, Tables, unread};
use crate::ReportError;
use polars::prelude::{
    HiveOptions, IntoLazy, IpcReader, LazyFrame, PlRefPath, ScanArgsParquet, SerReader,
};
use rrf_store::layout;
use std::path::Path;

/// Tables of a model: of nets, and of a transfer.
const MODEL_TABLES: [&str; 7] = [
    "tree",
    "weights",
    "metrics",
    "transfer",
    "transfer_tree",
    "transfer_cells",
    "transfer_parts",
];

/// A run's, a sweep's or a file's tables.
pub(super) fn open(path: &Path) -> Result<Tables> {
    if path.is_file() {
        return Ok(vec![("self", file(path)?)]);
    }
    if !path.is_dir() {
        return Err(ReportError::input(path, "no such file or folder"));
    }
    let mut tables = Tables::new();
    let results = path.join("results.parquet");
    if results.is_file() {
        tables.push(("results", file(&results)?));
    }
    let samples = layout::samples_folder(path);
    if has_parquet(&samples) {
        tables.push(("samples", parquet(&samples)?));
    }
    // a run, or its folder `model` itself
    for folder in [layout::model_folder(path), path.to_path_buf()] {
        for name in MODEL_TABLES {
            let table = folder.join(format!("{name}.arrow"));
            if table.is_file() {
                tables.push((name, file(&table)?));
            }
        }
    }
    if tables.is_empty() && has_parquet(path) {
        tables.push(("self", parquet(path)?));
    }
    if tables.is_empty() {
        let told = "neither a run (samples/, model/), nor a sweep (results.parquet), nor a folder of \
                    Parquet files; name one, or a Parquet or Arrow file";
        return Err(ReportError::input(path, told));
    }
    Ok(tables)
}

/// One file, by its first bytes: endings can lie.
fn file(path: &Path) -> Result<LazyFrame> {
    let mut magic = [0u8; 6];
    let mut file = std::fs::File::open(path).map_err(unread(path))?;
    let read = std::io::Read::read(&mut file, &mut magic).map_err(unread(path))?;
    match &magic[..read] {
        [b'P', b'A', b'R', b'1', ..] => parquet(path),
        b"ARROW1" => arrow(path),
        _ => {
            let told = "neither a Parquet nor an Arrow IPC file; name one, or a run's folder";
            Err(ReportError::input(path, told))
        }
    }
}

fn parquet(path: &Path) -> Result<LazyFrame> {
    let refused = |e| ReportError::input(path, e);
    let args = ScanArgsParquet {
        hive_options: HiveOptions {
            enabled: Some(path.is_dir()),
            ..HiveOptions::new_enabled()
        },
        ..ScanArgsParquet::default()
    };
    let place = PlRefPath::try_from_path(path).map_err(refused)?;
    LazyFrame::scan_parquet(place, args).map_err(refused)
}

fn arrow(path: &Path) -> Result<LazyFrame> {
    let file = std::fs::File::open(path).map_err(unread(path))?;
    let frame = IpcReader::new(file).finish();
    Ok(frame.map_err(|e| ReportError::input(path, e))?.lazy())
}

/// Whether a Parquet file lies in the folder or in one of its folders.
fn has_parquet(folder: &Path) -> bool {
    let entries = |folder: &Path| std::fs::read_dir(folder).into_iter().flatten().flatten();
    let is_parquet = |path: &Path| path.extension().is_some_and(|e| e == "parquet");
    entries(folder).any(|entry| {
        let path = entry.path();
        is_parquet(&path) || entries(&path).any(|inner| is_parquet(&inner.path()))
    })
}
