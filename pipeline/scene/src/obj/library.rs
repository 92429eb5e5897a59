//! The libraries that an OBJ file names.

use super::mtl::{self, Mtl};
use crate::SceneError;
use crate::file;
use crate::resolve;
use crate::warn::Warnings;
use std::path::Path;

/// Reads the libraries named, with their lines, in the OBJ file `path`. One that cannot be
/// read is a warning.
pub(super) fn read(
    path: &Path,
    named: &[(u32, String)],
    warnings: &mut Warnings,
) -> Result<Vec<Mtl>, SceneError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut library = Vec::new();
    for (line, names) in named {
        for name in divided(folder, names) {
            let found = resolve::find(&[folder], name);
            match file::read_bytes(&found.path) {
                Ok(bytes) => {
                    if found.is_guess {
                        let message = format!("{name} is read from {}", found.path.display());
                        warnings.add(place(path, *line), message);
                    }
                    library.extend(mtl::parse(&found.path, &file::text(&bytes), warnings)?);
                }
                Err(error) => warnings.add(place(path, *line), error.to_string()),
            }
        }
    }
    Ok(library)
}

/// The names of one statement: one name with blanks where there is such a file, else as many
/// as there are words.
fn divided<'a>(folder: &Path, names: &'a str) -> Vec<&'a str> {
    let is_there = |name: &str| resolve::find(&[folder], name).path.is_file();
    if is_there(names) {
        return vec![names];
    }
    let words: Vec<&str> = names.split_whitespace().collect();
    if words.iter().any(|word| is_there(word)) {
        return words;
    }
    vec![names]
}

/// `file.obj:line`.
pub(super) fn place(path: &Path, line: u32) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    format!("{}:{line}", name.to_string_lossy())
}
