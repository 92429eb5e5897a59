//! Reading a file whole.

use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::path::Path;

/// The bytes of a regular file of at most `limit` bytes. Devices and pipes, which may never end
/// or never begin, are refused.
///
/// # Errors
/// The system's.
pub fn read_regular(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    let found = path.metadata()?;
    if found.is_dir() {
        return Err(ErrorKind::IsADirectory.into());
    }
    if !found.is_file() {
        return Err(io::Error::new(
            ErrorKind::InvalidInput,
            "not a regular file",
        ));
    }
    let mut bytes = Vec::new();
    // a file can grow
    if found.len() <= limit {
        let mut rest = File::open(path)?.take(limit.saturating_add(1));
        rest.read_to_end(&mut bytes)?;
    }
    let size = found.len().max(bytes.len() as u64);
    if size > limit {
        let message = format!("it has {size} bytes; at most {limit} are read");
        return Err(io::Error::new(ErrorKind::InvalidInput, message));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_files_of_bounded_size_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        std::fs::write(&path, "four").unwrap();
        assert_eq!(read_regular(&path, 4).unwrap(), b"four");
        assert!(read_regular(&path, 3).is_err());
        assert!(read_regular(folder.path(), 4).is_err());
        #[cfg(unix)]
        assert!(read_regular(Path::new("/dev/zero"), 4).is_err());
    }
}
