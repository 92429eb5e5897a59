//! Files under a name of their own until they are whole: `NAME.N.tmp`.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// Left-overs and writers at work that a name is tried past.
const MOST: usize = 1000;

/// A new file, never one that another writer has open: left-overs of killed writers, writers
/// at work and files of others only move the number up.
pub(crate) fn create(folder: &Path, name: &str) -> io::Result<(File, PathBuf)> {
    for n in 0..MOST {
        let path = folder.join(format!("{name}.{n}.tmp"));
        let mut options = OpenOptions::new();
        match options.read(true).write(true).create_new(true).open(&path) {
            // one that was removed as a left-over before it was locked is no more
            Ok(file) if hold(&file)? => return Ok((file, path)),
            Ok(_) => {}
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
    }
    let message = format!("{MOST} unfinished files of this name are there");
    Err(io::Error::new(ErrorKind::AlreadyExists, message))
}

/// An empty file to write and read, without a name where the system allows that: it goes when it
/// is closed, whatever ends the process. Elsewhere it is a left-over.
///
/// # Errors
/// The system's.
pub fn scratch(folder: &Path, name: &str) -> io::Result<File> {
    let (file, path) = create(folder, name)?;
    // refused where open files keep their names
    let _ = fs::remove_file(&path);
    Ok(file)
}

/// Whether a name is one that files are staged under.
pub fn is_staged_name(name: &str) -> bool {
    let number = name.strip_suffix(".tmp").and_then(|n| n.rsplit_once('.'));
    number.is_some_and(|(_, n)| !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit()))
}

/// Removes a staged file unless a process is at work on it.
///
/// # Errors
/// The system's; a file that is gone already is none.
pub fn remove_left_over(path: &Path) -> io::Result<()> {
    let removed = match OpenOptions::new().write(true).open(path) {
        Ok(file) => match file.try_lock() {
            Ok(()) => fs::remove_file(path),
            // its writer is alive, or nobody can tell
            Err(TryLockError::WouldBlock | TryLockError::Error(_)) => Ok(()),
        },
        Err(error) => Err(error),
    };
    match removed {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

/// Marks a file as one that a process is at work on, as long as it is open; false where it was
/// taken for a left-over before.
fn hold(file: &File) -> io::Result<bool> {
    match file.lock() {
        // where there are no locks, nothing is taken for a left-over
        Err(error) if error.kind() == ErrorKind::Unsupported => return Ok(true),
        other => other?,
    }
    is_linked(file)
}

#[cfg(unix)]
fn is_linked(file: &File) -> io::Result<bool> {
    use std::os::unix::fs::MetadataExt;
    Ok(file.metadata()?.nlink() > 0)
}

#[cfg(not(unix))]
fn is_linked(_: &File) -> io::Result<bool> {
    Ok(true)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_writer_at_work_keeps_its_file() {
        let folder = tempfile::tempdir().unwrap();
        let (file, path) = create(folder.path(), "a").unwrap();
        remove_left_over(&path).unwrap();
        assert!(path.exists());
        drop(file);
        remove_left_over(&path).unwrap();
        assert!(!path.exists());
        remove_left_over(&path).unwrap();
    }

    #[test]
    fn names_end_in_a_number() {
        for name in ["a.0.tmp", ".a.b.12.tmp"] {
            assert!(is_staged_name(name), "{name}");
        }
        for name in ["a.tmp", "a..tmp", "a.0.tmp.x", "a.0"] {
            assert!(!is_staged_name(name), "{name}");
        }
    }
}
