//! Reading a file whole.

use crate::SceneError;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// The bytes of a regular file. Devices and pipes, which may never end, are refused.
pub(crate) fn read_bytes(path: &Path) -> Result<Vec<u8>, SceneError> {
    let failed = |source| SceneError::Io {
        path: path.to_path_buf(),
        source,
    };
    let is_file = path.metadata().map_err(failed)?.is_file();
    if !is_file {
        return Err(failed(io::Error::other("not a regular file")));
    }
    let mut bytes = Vec::new();
    File::open(path)
        .and_then(|mut file| file.read_to_end(&mut bytes))
        .map_err(failed)?;
    Ok(bytes)
}
