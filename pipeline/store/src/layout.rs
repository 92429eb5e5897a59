//! Names in a run folder.

use crate::atomic::io_error;
use crate::error::StoreError;
use rrf_files::{is_staged_name, remove_left_over};
use std::ffi::OsStr;
use std::fs::DirEntry;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// The dataset's folder; nothing but Parquet parts is ever in it.
pub fn samples_folder(run: &Path) -> PathBuf {
    run.join("samples")
}

/// In place of a cell: rows of the whole domain that only judge, in a folder of their own.
pub const TEST: u32 = u32::MAX;

/// The folder of one cell's parts.
pub fn cell_folder(run: &Path, cell: u32) -> PathBuf {
    match cell {
        TEST => run.join("test"),
        _ => samples_folder(run).join(format!("cell={cell:06}")),
    }
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

/// Some of a round's tasks with all that they need.
pub fn chapter_path(run: &Path, round: u32, number: u32) -> PathBuf {
    round_folder(run, round).join(format!("tasks/{number:05}.json"))
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

/// Removes what killed writers left: unfinished files in `staging/` and, named `.NAME.N.tmp`,
/// beside the files that they would have become. The files of a writer still at work stay, and
/// no file that a reader knows is touched.
///
/// # Errors
/// [`StoreError::Io`].
pub fn remove_unfinished(run: &Path) -> Result<(), StoreError> {
    remove_files(&staging_folder(run), &|name| name.ends_with(".tmp"))?;
    let hidden = |name: &str| name.starts_with('.') && is_staged_name(name);
    for entry in entries(run)? {
        if entry.file_name() == *OsStr::new("samples") {
            continue;
        }
        match is_folder(&entry)? {
            true => remove_files(&entry.path(), &hidden)?,
            false => remove_if(&entry, &hidden)?,
        }
    }
    Ok(())
}

fn remove_files(folder: &Path, wanted: &dyn Fn(&str) -> bool) -> Result<(), StoreError> {
    for entry in entries(folder)? {
        match is_folder(&entry)? {
            true => remove_files(&entry.path(), wanted)?,
            false => remove_if(&entry, wanted)?,
        }
    }
    Ok(())
}

fn remove_if(entry: &DirEntry, wanted: &dyn Fn(&str) -> bool) -> Result<(), StoreError> {
    let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
    if !is_file || !entry.file_name().to_str().is_some_and(wanted) {
        return Ok(());
    }
    let path = entry.path();
    remove_left_over(&path).map_err(|e| io_error(&path, "remove", e))
}

/// Links are not followed.
fn is_folder(entry: &DirEntry) -> Result<bool, StoreError> {
    match entry.file_type() {
        Ok(kind) => Ok(kind.is_dir()),
        // another process was faster
        Err(e) if e.kind() == ErrorKind::NotFound => Ok(false),
        Err(e) => Err(io_error(&entry.path(), "read", e)),
    }
}

/// What lies in a folder; nothing, where there is none.
fn entries(folder: &Path) -> Result<Vec<DirEntry>, StoreError> {
    match std::fs::read_dir(folder) {
        Ok(found) => found
            .collect::<Result<_, _>>()
            .map_err(|e| io_error(folder, "read", e)),
        Err(e) if e.kind() == ErrorKind::NotFound => Ok(Vec::new()),
        Err(e) => Err(io_error(folder, "read", e)),
    }
}

fn list(folder: &Path, parse: impl Fn(&str) -> Option<u32>) -> Result<Vec<u32>, StoreError> {
    let mut numbers = Vec::new();
    for entry in entries(folder)? {
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
