//! Where in which file something is, and faults and warnings that point there.

use crate::{SceneError, Warning};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// A place in one of the files read so far; line and column count from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Place {
    pub file: u32,
    pub line: u32,
    pub column: u32,
}

/// Why reading stops.
#[derive(Debug)]
pub(super) enum Fault {
    /// A fault of the text.
    At { place: Place, message: String },
    /// A fault that names its own place, as of a PLY file.
    Elsewhere(SceneError),
}

/// A result of reading.
pub(super) type Read<T> = Result<T, Fault>;

/// A fault at a place.
pub(super) fn fault<T>(place: Place, message: impl Into<String>) -> Read<T> {
    Err(Fault::At {
        place,
        message: message.into(),
    })
}

/// The names of the files read so far, by [`Place::file`].
#[derive(Debug, Default)]
pub(super) struct Files(Vec<PathBuf>);

impl Files {
    /// Adds a file and returns its id; the same path has one id.
    pub fn id(&mut self, path: &Path) -> u32 {
        if let Some(known) = self.0.iter().position(|file| file == path) {
            return known as u32;
        }
        self.0.push(path.to_path_buf());
        (self.0.len() - 1) as u32
    }

    /// The path of a file.
    pub fn path(&self, file: u32) -> PathBuf {
        self.0.get(file as usize).cloned().unwrap_or_default()
    }

    /// The library's error for a fault.
    pub fn error(&self, fault: Fault) -> SceneError {
        match fault {
            Fault::At { place, message } => SceneError::Syntax {
                path: self.path(place.file),
                line: place.line,
                column: place.column,
                message,
            },
            Fault::Elsewhere(error) => error,
        }
    }
}

/// Warnings in the order of their first places; the same words again only count.
#[derive(Debug, Default)]
pub(super) struct Warnings {
    found: Vec<(Place, String, usize)>,
    known: HashMap<String, usize>,
    beyond: usize,
}

/// More different warnings than anybody reads.
const MAX_WARNINGS: usize = 1000;

impl Warnings {
    /// Adds a warning.
    pub fn add(&mut self, place: Place, message: impl Into<String>) {
        let message = message.into();
        if let Some(entry) = self
            .known
            .get(&message)
            .and_then(|&i| self.found.get_mut(i))
        {
            entry.2 += 1;
        } else if self.found.len() < MAX_WARNINGS {
            self.known.insert(message.clone(), self.found.len());
            self.found.push((place, message, 1));
        } else {
            self.beyond += 1;
        }
    }

    /// The scene's form of them.
    pub fn finish(self, files: &Files) -> Vec<Warning> {
        let mut warnings: Vec<Warning> = self
            .found
            .into_iter()
            .map(|(place, message, times)| Warning {
                place: format!(
                    "{}:{}:{}",
                    files.path(place.file).display(),
                    place.line,
                    place.column
                ),
                message: match times {
                    1 => message,
                    _ => format!("{message} (and at {} more places)", times - 1),
                },
            })
            .collect();
        if self.beyond > 0 {
            warnings.push(Warning {
                place: files.path(0).display().to_string(),
                message: format!("{} more warnings are not listed", self.beyond),
            });
        }
        warnings
    }
}
