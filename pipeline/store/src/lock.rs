//! Who works on a folder: one process at a time, until it ends, whatever ends it.

use crate::atomic::{create_folder, io_error};
use crate::error::StoreError;
use std::collections::BTreeMap;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError, Weak};

/// The file that is locked. It is empty while nobody works; what is in it names the holder.
pub const LOCK_FILE: &str = "lock";

/// Longest name of a holder that is read.
const MAX_HOLDER: u64 = 1000;

/// Folders that this process holds.
static HELD: Mutex<BTreeMap<PathBuf, Weak<FolderLock>>> = Mutex::new(BTreeMap::new());

/// Holds a folder for this process. The lock is the system's (flock on `lock`), so that it ends
/// with the process, and a machine's crash leaves none.
#[derive(Debug)]
pub struct FolderLock {
    file: File,
}

impl FolderLock {
    /// Makes the folder where missing and takes its lock. Within a process the lock is shared.
    ///
    /// # Errors
    /// [`StoreError::Busy`] where another process holds it; [`StoreError::Io`].
    pub fn take(folder: &Path) -> Result<Arc<FolderLock>, StoreError> {
        create_folder(folder)?;
        let known = std::fs::canonicalize(folder).map_err(|e| io_error(folder, "open", e))?;
        let mut held = HELD.lock().unwrap_or_else(PoisonError::into_inner);
        held.retain(|_, lock| lock.strong_count() > 0);
        if let Some(lock) = held.get(&known).and_then(Weak::upgrade) {
            return Ok(lock);
        }
        let lock = Arc::new(FolderLock::take_anew(folder)?);
        held.insert(known, Arc::downgrade(&lock));
        Ok(lock)
    }

    fn take_anew(folder: &Path) -> Result<FolderLock, StoreError> {
        let path = folder.join(LOCK_FILE);
        // a link would have another's file written
        let is_own = path
            .symlink_metadata()
            .map_or(true, |found| found.is_file());
        if !is_own {
            return Err(io_error(&path, "lock", ErrorKind::InvalidInput.into()));
        }
        let mut options = OpenOptions::new();
        let options = options.read(true).write(true).create(true).truncate(false);
        let mut file = options
            .open(&path)
            .map_err(|e| io_error(&path, "lock", e))?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let mut holder = String::new();
                // for people: what cannot be read is left out
                let _ = (&mut file).take(MAX_HOLDER).read_to_string(&mut holder);
                return Err(StoreError::Busy {
                    path: folder.into(),
                    holder: match holder.trim() {
                        "" => "another process".into(),
                        holder => holder.into(),
                    },
                });
            }
            Err(TryLockError::Error(e)) => return Err(io_error(&path, "lock", e)),
        }
        let named = file
            .set_len(0)
            .and_then(|()| writeln!(file, "{}", holder()));
        named.map_err(|e| io_error(&path, "write", e))?;
        Ok(FolderLock { file })
    }
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        // for people: the lock itself ends with the file
        let _ = self.file.set_len(0);
    }
}

/// This process, as another one names it: `rrf bake (process 42 on host)`.
fn holder() -> String {
    let words: Vec<String> = std::env::args().take(2).collect();
    let program = words.first().map(Path::new).and_then(Path::file_name);
    let program = program.map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let command = words.get(1).map_or("", String::as_str);
    let host = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap_or_default();
    let host = match host.trim() {
        "" => String::new(),
        host => format!(" on {host}"),
    };
    format!("{program} {command} (process {}{host})", std::process::id())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lock_is_shared_within_a_process_and_ends_with_its_last_holder() {
        let folder = tempfile::tempdir().unwrap();
        let run = folder.path().join("a/run");
        let text = || std::fs::read_to_string(run.join(LOCK_FILE)).unwrap();
        let first = FolderLock::take(&run).unwrap();
        let second = FolderLock::take(&run).unwrap();
        assert!(Arc::ptr_eq(&first, &second));
        assert!(text().contains("process"));
        drop(first);
        assert!(!text().is_empty());
        drop(second);
        assert!(text().is_empty());
    }

    #[test]
    fn another_holder_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let mut other = File::create_new(folder.path().join(LOCK_FILE)).unwrap();
        other.lock().unwrap();
        writeln!(other, "rrf bake (process 42)").unwrap();
        let error = FolderLock::take(folder.path()).unwrap_err();
        assert!(!error.is_bad_input());
        let message = error.to_string();
        assert!(
            message.contains("in use by rrf bake (process 42)"),
            "{message}"
        );
        drop(other);
        FolderLock::take(folder.path()).unwrap();
    }

    #[cfg(unix)]
    #[test]
    fn a_link_is_not_followed() {
        let folder = tempfile::tempdir().unwrap();
        let letter = folder.path().join("letter");
        std::fs::write(&letter, "dear").unwrap();
        let run = folder.path().join("run");
        create_folder(&run).unwrap();
        std::os::unix::fs::symlink(&letter, run.join(LOCK_FILE)).unwrap();
        assert!(FolderLock::take(&run).is_err());
        assert_eq!(std::fs::read_to_string(&letter).unwrap(), "dear");
    }
}
