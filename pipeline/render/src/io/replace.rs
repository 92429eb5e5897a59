//! Files that are written whole or not at all.

use crate::error::RenderError;
use std::io;
use std::path::Path;

/// Writes what `encode` makes by [`rrf_files::replace`]: a failure leaves what was there.
pub(super) fn replace_file(
    path: &Path,
    encode: impl FnOnce() -> Result<Vec<u8>, String>,
) -> Result<(), RenderError> {
    let bytes = encode().map_err(io::Error::other);
    bytes
        .and_then(|bytes| rrf_files::replace(path, &bytes))
        .map_err(|source| RenderError::Write {
            path: path.to_path_buf(),
            source,
        })
}
