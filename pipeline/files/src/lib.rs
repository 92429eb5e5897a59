//! The one writer of outputs: every file appears whole or not at all.
//!
//! [`replace`] stages the new content under a name of its own beside the file, syncs it and
//! renames it over the file. What was there before stays on every failure, a symbolic link is
//! followed, and a device or pipe is written in place. A staged file is locked while its writer
//! lives, so that [`remove_left_over`] removes those of killed writers only.
//!
//! ```
//! let folder = tempfile::tempdir()?;
//! let path = folder.path().join("a.txt");
//! rrf_files::probe_writable(&path)?;
//! rrf_files::replace(&path, b"whole")?;
//! assert_eq!(std::fs::read(&path)?, b"whole");
//! # Ok::<(), std::io::Error>(())
//! ```

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

mod kinds;
mod read;
mod replace;
mod staged;
mod standard;

pub use kinds::is_permanent;
pub use read::read_regular;
pub use replace::{make_folder, probe_writable, replace, replace_from, replace_with};
pub use staged::{is_staged_name, remove_left_over, scratch};
pub use standard::{print_error, print_or_end};
