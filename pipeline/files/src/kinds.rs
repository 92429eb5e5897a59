//! Which errors of the system a person has to mend.

use std::io::{Error, ErrorKind};

/// Whether the same call fails again until a person changes the input: a missing folder, a
/// read-only one. Otherwise it could succeed when tried again: a full disk, a failing device.
pub fn is_permanent(error: &Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::NotFound
            | ErrorKind::PermissionDenied
            | ErrorKind::ReadOnlyFilesystem
            | ErrorKind::NotADirectory
            | ErrorKind::IsADirectory
            | ErrorKind::AlreadyExists
            | ErrorKind::InvalidInput
            | ErrorKind::InvalidFilename
    )
}
