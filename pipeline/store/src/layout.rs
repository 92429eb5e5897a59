//! Names in a run folder.

use crate::atomic::io_error;
use crate::error::StoreError;
use std::path::{Path, PathBuf};

/// The dataset's folder; nothing but Parquet parts is ever in it.
pub fn samples_folder(run: &Path) -> PathBuf {
    run.join("samples")
}

/// The folder of one cell's parts.
pub fn cell_folder(run: &Path, cell: u32) -> PathBuf {
    samples_folder(run).join(format!("cell={cell:06}"))
}

/// One part of one cell.
pub fn part_path(run: &Path, cell: u32, part: u32) -> PathBuf {
    cell_folder(run, cell).join(format!("part-{part:05}.parquet"))
}

/// Where unfinished files are; safe to empty while nothing runs.
pub fn staging_folder(run: &Path) -> PathBuf {
    run.join("staging")
}

/// The model's folder.
pub fn model_folder(run: &Path) -> PathBuf {
    run.join("model")
}

/// What one round of a bake was asked and made, outside the model's tables.
pub fn round_folder(run: &Path, round: u32) -> PathBuf {
    run.join("rounds").join(format!("{round:03}"))
}

/// The table of one round's tasks.
pub fn task_table_path(run: &Path, round: u32) -> PathBuf {
    round_folder(run, round).join("tasks.parquet")
}

/// One cell's fit of one round.
pub fn fit_folder(run: &Path, round: u32, cell: u32) -> PathBuf {
    round_folder(run, round).join(format!("fits/cell={cell:06}"))
}

/// Cells that have a folder, ascending.
///
/// # Errors
/// [`StoreError::Stray`] for anything else in `samples/`; [`StoreError::Io`].
pub fn list_cells(run: &Path) -> Result<Vec<u32>, StoreError> {
    list(&samples_folder(run), |name| {
        let cell = number(name, "cell=", "")?;
        (format!("cell={cell:06}") == name).then_some(cell)
    })
}

/// Numbers of a cell's parts, ascending; empty where the cell has no folder.
///
/// # Errors
/// [`StoreError::Stray`] for anything else in the folder; [`StoreError::Io`].
pub fn list_parts(run: &Path, cell: u32) -> Result<Vec<u32>, StoreError> {
    list(&cell_folder(run, cell), |name| {
        let part = number(name, "part-", ".parquet")?;
        (format!("part-{part:05}.parquet") == name).then_some(part)
    })
}

/// Removes what killed writers left in `staging/`. Only while no other process writes the run.
///
/// # Errors
/// [`StoreError::Io`].
pub fn clean_staging(run: &Path) -> Result<(), StoreError> {
    let folder = staging_folder(run);
    match std::fs::remove_dir_all(&folder) {
        Ok(()) => Ok(()),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(()),
        Err(e) => Err(io_error(&folder, "empty", e)),
    }
}

fn list(folder: &Path, parse: impl Fn(&str) -> Option<u32>) -> Result<Vec<u32>, StoreError> {
    let entries = match std::fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(e) => return Err(io_error(folder, "read", e)),
    };
    let mut numbers = Vec::new();
    for entry in entries {
        let entry = entry.map_err(|e| io_error(folder, "read", e))?;
        match entry.file_name().to_str().and_then(&parse) {
            Some(number) => numbers.push(number),
            None => return Err(StoreError::Stray { path: entry.path() }),
        }
    }
    numbers.sort_unstable();
    Ok(numbers)
}

fn number(name: &str, before: &str, after: &str) -> Option<u32> {
    name.strip_prefix(before)?.strip_suffix(after)?.parse().ok()
}
