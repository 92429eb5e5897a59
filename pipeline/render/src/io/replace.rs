//! Files that are written whole or not at all.

use crate::error::RenderError;
use std::path::Path;

/// Has a file written beside `path` and then renamed onto it: a failed write leaves what was there.
pub(super) fn replace_file(
    path: &Path,
    write: impl FnOnce(&Path) -> Result<(), String>,
) -> Result<(), RenderError> {
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(".part");
    let staged = path.with_file_name(name);
    let rename = || std::fs::rename(&staged, path).map_err(|e| e.to_string());
    write(&staged).and_then(|()| rename()).map_err(|reason| {
        // best effort: the first error is the one worth telling
        let _ = std::fs::remove_file(&staged);
        RenderError::Write {
            path: path.to_path_buf(),
            reason,
        }
    })
}
