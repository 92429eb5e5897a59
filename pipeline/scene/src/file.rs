//! Reading a file whole.

use crate::SceneError;
use std::io;
use std::path::Path;

/// The bytes of a regular file. Devices and pipes, which may never end, are refused.
pub(crate) fn read(path: &Path) -> io::Result<Vec<u8>> {
    if !path.metadata()?.is_file() {
        return Err(io::Error::other("not a regular file"));
    }
    std::fs::read(path)
}

/// [`read`], failing with the path.
pub(crate) fn read_bytes(path: &Path) -> Result<Vec<u8>, SceneError> {
    read(path).map_err(|source| SceneError::Io {
        path: path.to_path_buf(),
        source,
    })
}
