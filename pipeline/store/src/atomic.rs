//! Files appear whole or not at all: [`rrf_files`], with errors that name the file.

use crate::error::StoreError;
use std::fs::File;
use std::io::Write;
use std::path::Path;

/// Writes `bytes` to `path`: staged beside it as `.NAME.N.tmp`, synced, renamed over it.
/// A symbolic link is followed; a device or pipe is written in place.
///
/// # Errors
/// [`StoreError::Io`]; what was at `path` before is then unchanged.
pub fn atomic_write(path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    rrf_files::replace(path, bytes).map_err(|e| io_error(path, "write", e))
}

/// Writes `bytes` to `path`, staged as `staging/NAME.N.tmp`; both on one file system.
///
/// # Errors
/// [`StoreError::Io`]; what was at `path` before is then unchanged.
pub fn atomic_write_from(
    staging: &Path,
    name: &str,
    path: &Path,
    bytes: &[u8],
) -> Result<(), StoreError> {
    rrf_files::replace_from(staging, name, path, |file| file.write_all(bytes))
        .map_err(|e| io_error(path, "write", e))
}

/// Makes a folder and its parents where missing, durably.
///
/// # Errors
/// [`StoreError::Io`].
pub fn create_folder(path: &Path) -> Result<(), StoreError> {
    rrf_files::make_folder(path).map_err(|e| io_error(path, "create the folder", e))
}

/// An empty file to write and read, without a name where the system allows that: it goes when it
/// is closed, whatever ends the process. Elsewhere [`crate::layout::remove_unfinished`] removes it.
///
/// # Errors
/// [`StoreError::Io`].
pub fn scratch_file(folder: &Path, name: &str) -> Result<File, StoreError> {
    rrf_files::scratch(folder, name).map_err(|e| io_error(folder, "make a scratch file in", e))
}

/// Whether an output can be written, to be asked before long work.
///
/// # Errors
/// [`StoreError::Io`].
pub fn check_writable(path: &Path) -> Result<(), StoreError> {
    rrf_files::probe_writable(path).map_err(|e| io_error(path, "write", e))
}

pub(crate) fn io_error(path: &Path, action: &'static str, source: std::io::Error) -> StoreError {
    StoreError::Io {
        path: path.into(),
        action,
        source,
    }
}
