//! Replacing a file whole.

use crate::staged::create;
use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

/// Where an output goes.
enum Target {
    /// A file to be, in a folder, its links followed.
    File { folder: PathBuf, path: PathBuf },
    /// A device or pipe, written in place.
    Stream,
}

/// Writes `bytes` to `path`, staged beside it as `.NAME.N.tmp`.
///
/// # Errors
/// The system's; what was at `path` before is then unchanged.
pub fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    replace_with(path, |file| file.write_all(bytes))
}

/// [`replace`] with what `write` writes.
///
/// # Errors
/// Those of `write` and the system's; what was at `path` before is then unchanged.
pub fn replace_with(
    path: &Path,
    write: impl FnOnce(&mut File) -> io::Result<()>,
) -> io::Result<()> {
    match target(path)? {
        Target::Stream => write(&mut OpenOptions::new().write(true).open(path)?),
        Target::File { folder, path } => {
            let name = format!(".{}", file_name(&path)?);
            replace_from(&folder, &name, &path, write)
        }
    }
}

/// Writes `path`, staged as `staging/NAME.N.tmp`; both on one file system.
///
/// # Errors
/// As [`replace_with`].
pub fn replace_from(
    staging: &Path,
    name: &str,
    path: &Path,
    write: impl FnOnce(&mut File) -> io::Result<()>,
) -> io::Result<()> {
    let (mut file, temporary) = create(staging, name)?;
    let written = write(&mut file)
        .and_then(|()| file.sync_all())
        .and_then(|()| fs::rename(&temporary, path));
    if let Err(error) = written {
        // best effort: the write's own error is what matters, and a left-over is never read
        let _ = fs::remove_file(&temporary);
        return Err(error);
    }
    sync_folder(path.parent().unwrap_or(Path::new(".")))
}

/// Whether `path` can be written, to be asked before long work: its folder is there and takes a
/// new file.
///
/// # Errors
/// The system's, as [`replace`] would have it.
pub fn probe_writable(path: &Path) -> io::Result<()> {
    match target(path)? {
        Target::Stream => OpenOptions::new().write(true).open(path).map(|_| ()),
        Target::File { folder, path } => {
            let (_file, temporary) = create(&folder, &format!(".{}", file_name(&path)?))?;
            fs::remove_file(temporary)
        }
    }
}

/// Makes a folder and its parents where missing, durably.
///
/// # Errors
/// The system's.
pub fn make_folder(path: &Path) -> io::Result<()> {
    if path.as_os_str().is_empty() || path.is_dir() {
        return Ok(());
    }
    if let Some(parent) = path.parent() {
        make_folder(parent)?;
    }
    match fs::create_dir(path) {
        Ok(()) => sync_folder(path.parent().unwrap_or(Path::new("."))),
        // another writer was faster
        Err(error) if error.kind() == ErrorKind::AlreadyExists && path.is_dir() => Ok(()),
        Err(error) => Err(error),
    }
}

fn target(path: &Path) -> io::Result<Target> {
    let path = match fs::metadata(path) {
        Ok(found) if found.is_dir() => return Err(ErrorKind::IsADirectory.into()),
        Ok(found) if !found.is_file() => return Ok(Target::Stream),
        Ok(_) => fs::canonicalize(path)?,
        Err(_) => end_of_links(path)?,
    };
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_path_buf(),
        _ => PathBuf::from("."),
    };
    Ok(Target::File { folder, path })
}

/// The file that a link to nothing would be.
fn end_of_links(path: &Path) -> io::Result<PathBuf> {
    const MOST: usize = 40;
    let mut path = path.to_path_buf();
    for _ in 0..MOST {
        match fs::read_link(&path) {
            Ok(to) => path = path.parent().unwrap_or(Path::new("")).join(to),
            Err(_) => return Ok(path),
        }
    }
    Err(io::Error::new(ErrorKind::InvalidInput, "a circle of links"))
}

fn file_name(path: &Path) -> io::Result<&str> {
    let name = path.file_name().and_then(|name| name.to_str());
    name.ok_or_else(|| ErrorKind::InvalidFilename.into())
}

fn sync_folder(path: &Path) -> io::Result<()> {
    let path = if path.as_os_str().is_empty() {
        Path::new(".")
    } else {
        path
    };
    File::open(path)?.sync_all()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let name = |entry: io::Result<fs::DirEntry>| entry.unwrap().file_name();
        let mut names: Vec<String> = entries
            .map(|entry| name(entry).into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_failed_write_keeps_the_old_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        replace(&path, b"old").unwrap();
        let failed = replace_with(&path, |file| {
            file.write_all(b"new, half")?;
            Err(ErrorKind::StorageFull.into())
        });
        assert_eq!(failed.unwrap_err().kind(), ErrorKind::StorageFull);
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn files_of_others_are_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        for other in ["a.exr.part", ".a.exr.0.tmp"] {
            fs::write(folder.path().join(other), other).unwrap();
        }
        replace(&path, b"picture").unwrap();
        assert_eq!(
            names(folder.path()),
            [".a.exr.0.tmp", "a.exr", "a.exr.part"]
        );
        let other = fs::read(folder.path().join(".a.exr.0.tmp")).unwrap();
        assert_eq!(other, b".a.exr.0.tmp");
    }

    #[test]
    fn whether_a_path_can_be_written_is_said_before() {
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("none/a.exr");
        assert!(is_missing(probe_writable(&missing)));
        let kind = probe_writable(folder.path()).unwrap_err().kind();
        assert_eq!(kind, ErrorKind::IsADirectory);
        probe_writable(&folder.path().join("a.exr")).unwrap();
        assert!(names(folder.path()).is_empty());
    }

    fn is_missing(result: io::Result<()>) -> bool {
        result.is_err_and(|error| error.kind() == ErrorKind::NotFound)
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("real"), "old").unwrap();
        symlink("real", at("link")).unwrap();
        symlink("made", at("to nothing")).unwrap();
        symlink("circle", at("circle")).unwrap();
        replace(&at("link"), b"new").unwrap();
        replace(&at("to nothing"), b"made").unwrap();
        assert_eq!(fs::read(at("real")).unwrap(), b"new");
        assert_eq!(fs::read(at("made")).unwrap(), b"made");
        assert!(at("link").is_symlink() && at("to nothing").is_symlink());
        assert!(replace(&at("circle"), b"x").is_err());
    }
}
