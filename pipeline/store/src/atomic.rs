//! Files appear whole or not at all: written under another name, synced, renamed.

use crate::error::StoreError;
use std::fs::{self, File, OpenOptions};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

/// Writes `bytes` to `path`: staged beside it as `.NAME.N.tmp`, synced, renamed over it.
/// A symbolic link is followed; a device or pipe is written in place.
///
/// # Errors
/// [`StoreError::Io`]; what was at `path` before is then unchanged.
pub fn atomic_write(path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    let path = match fs::metadata(path) {
        Ok(meta) if meta.is_dir() => {
            return Err(io_error(path, "write", ErrorKind::IsADirectory.into()));
        }
        Ok(meta) if !meta.is_file() => return write_in_place(path, bytes),
        Ok(_) => fs::canonicalize(path).map_err(|e| io_error(path, "write", e))?,
        Err(_) => path.to_path_buf(),
    };
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let name = file_name(&path)?;
    atomic_write_from(folder, &format!(".{name}"), &path, bytes)
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
    let (mut file, temporary) = create_temporary(staging, name)?;
    let written = file
        .write_all(bytes)
        .and_then(|()| file.sync_all())
        .map_err(|e| io_error(path, "write", e))
        .and_then(|()| fs::rename(&temporary, path).map_err(|e| io_error(path, "write", e)));
    if let Err(error) = written {
        // Best effort: the write's own error is what matters, and a left-over is never read.
        let _ = fs::remove_file(&temporary);
        return Err(error);
    }
    sync_folder(path.parent().unwrap_or(Path::new(".")))
}

/// Makes a folder and its parents where missing, durably.
///
/// # Errors
/// [`StoreError::Io`].
pub fn create_folder(path: &Path) -> Result<(), StoreError> {
    if path.as_os_str().is_empty() || path.is_dir() {
        return Ok(());
    }
    if let Some(parent) = path.parent() {
        create_folder(parent)?;
    }
    match fs::create_dir(path) {
        Ok(()) => sync_folder(path.parent().unwrap_or(Path::new("."))),
        // Another writer was faster.
        Err(e) if e.kind() == ErrorKind::AlreadyExists && path.is_dir() => Ok(()),
        Err(e) => Err(io_error(path, "create the folder", e)),
    }
}

/// An empty file to write and read, without a name where the system allows that: it goes when it
/// is closed, whatever ends the process. Elsewhere [`crate::layout::remove_unfinished`] removes it.
///
/// # Errors
/// [`StoreError::Io`].
pub fn scratch_file(folder: &Path, name: &str) -> Result<File, StoreError> {
    let (file, path) = create_temporary(folder, name)?;
    // Refused where open files keep their names; it is then a left-over like any other.
    let _ = fs::remove_file(&path);
    Ok(file)
}

fn write_in_place(path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    OpenOptions::new()
        .write(true)
        .open(path)
        .and_then(|mut file| file.write_all(bytes))
        .map_err(|e| io_error(path, "write", e))
}

/// A new file, never one that another writer has open: left-overs of killed runs and writers
/// at work on the same file only move the number up.
fn create_temporary(folder: &Path, name: &str) -> Result<(File, PathBuf), StoreError> {
    let mut last = None;
    for n in 0..1000 {
        let path = folder.join(format!("{name}.{n}.tmp"));
        let mut options = OpenOptions::new();
        match options.read(true).write(true).create_new(true).open(&path) {
            Ok(file) => return Ok((file, path)),
            Err(e) if e.kind() == ErrorKind::AlreadyExists => last = Some((path, e)),
            Err(e) => return Err(io_error(&path, "create", e)),
        }
    }
    let (path, error) = last.unwrap_or((folder.into(), ErrorKind::AlreadyExists.into()));
    Err(io_error(&path, "create", error))
}

fn sync_folder(path: &Path) -> Result<(), StoreError> {
    let path = if path.as_os_str().is_empty() {
        Path::new(".")
    } else {
        path
    };
    File::open(path)
        .and_then(|folder| folder.sync_all())
        .map_err(|e| io_error(path, "sync the folder", e))
}

fn file_name(path: &Path) -> Result<&str, StoreError> {
    path.file_name()
        .and_then(|name| name.to_str())
        .ok_or_else(|| io_error(path, "write", ErrorKind::InvalidFilename.into()))
}

pub(crate) fn io_error(path: &Path, action: &'static str, source: std::io::Error) -> StoreError {
    StoreError::Io {
        path: path.into(),
        action,
        source,
    }
}
