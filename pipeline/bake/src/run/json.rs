//! JSON files of a run.

use crate::error::BakeError;
use rrf_store::StoreError;
use rrf_store::atomic::{atomic_write, create_folder};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::io::ErrorKind;
use std::path::Path;

/// Reads a file; none where it does not exist.
pub(crate) fn read_json<T: DeserializeOwned>(path: &Path) -> Result<Option<T>, BakeError> {
    match std::fs::read(path) {
        Ok(text) => Ok(Some(
            serde_json::from_slice(&text).map_err(|error| corrupt(path, error))?,
        )),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        Err(error) => Err(io_error(path, "read", error).into()),
    }
}

/// Writes a file where it does not exist with the same bytes already.
pub(crate) fn write_json(path: &Path, value: &impl Serialize) -> Result<(), BakeError> {
    let mut text = serde_json::to_vec(value).map_err(|error| corrupt(path, error))?;
    text.push(b'\n');
    if std::fs::read(path).is_ok_and(|found| found == text) {
        return Ok(());
    }
    if let Some(folder) = path.parent() {
        create_folder(folder)?;
    }
    Ok(atomic_write(path, &text)?)
}

/// Removes a file, should it exist.
pub(crate) fn remove_file(path: &Path) -> Result<(), StoreError> {
    removed(path, std::fs::remove_file(path))
}

/// Removes a folder with everything in it, should it exist.
pub(crate) fn remove_folder(path: &Path) -> Result<(), StoreError> {
    removed(path, std::fs::remove_dir_all(path))
}

fn removed(path: &Path, result: std::io::Result<()>) -> Result<(), StoreError> {
    match result {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(io_error(path, "remove", error)),
        _ => Ok(()),
    }
}

fn io_error(path: &Path, action: &'static str, source: std::io::Error) -> StoreError {
    StoreError::Io {
        path: path.into(),
        action,
        source,
    }
}

/// The error of a file whose content is wrong.
pub(crate) fn corrupt(path: &Path, reason: impl ToString) -> StoreError {
    StoreError::Corrupt {
        path: path.into(),
        format: "JSON",
        reason: reason.to_string(),
        remedy: "Bake into a new folder",
    }
}
