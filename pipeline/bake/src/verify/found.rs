//! Findings of the checks.

use crate::error::BakeError;
use serde::Serialize;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// A file that is not what was written.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Damage {
    /// The file.
    pub path: PathBuf,
    /// The damage.
    pub what: String,
    /// The remedy.
    pub remedy: String,
}

impl Damage {
    fn new(path: &Path, what: impl ToString, remedy: impl Into<String>) -> Damage {
        Damage {
            path: path.into(),
            what: what.to_string(),
            remedy: remedy.into(),
        }
    }
}

/// Findings of one check: the files that belong to the run, and damages.
#[derive(Default)]
pub(super) struct Found {
    pub known: BTreeSet<PathBuf>,
    pub damages: Vec<Damage>,
}

impl Found {
    pub fn damage(&mut self, path: &Path, what: impl ToString, remedy: impl Into<String>) {
        self.damages.push(Damage::new(path, what, remedy));
    }

    pub fn add(&mut self, other: Found) {
        self.known.extend(other.known);
        self.damages.extend(other.damages);
    }
}

pub(super) const RESUME: &str = "`rrf bake SCENE -o RUN --resume` makes it again";

/// An error without the path that stands before it anyway, and without its own remedy.
pub(super) fn text(error: &BakeError) -> String {
    let (text, path) = (error.to_string(), error.path());
    let path = path.map(|path| format!("{}: ", path.display()));
    let text = path
        .and_then(|path| text.strip_prefix(&path).map(str::to_owned))
        .unwrap_or(text);
    match text.split_once(". ") {
        Some((what, _)) => what.into(),
        None => text,
    }
}

impl BakeError {
    /// The file of an error of the store.
    fn path(&self) -> Option<&Path> {
        match self {
            BakeError::Store(error) => error.path(),
            _ => None,
        }
    }
}

/// The result of reading a file of the run: none where it is damaged, which is noted.
pub(super) fn noted<T>(
    found: &mut Found,
    path: &Path,
    result: Result<T, BakeError>,
    remedy: impl Into<String>,
) -> Result<Option<T>, BakeError> {
    match result {
        Ok(value) => Ok(Some(value)),
        Err(BakeError::Store(error)) if error.is_damage() => {
            let at = error.path().unwrap_or(path).to_path_buf();
            found.damage(&at, text(&BakeError::Store(error)), remedy);
            Ok(None)
        }
        Err(error) => Err(error),
    }
}
