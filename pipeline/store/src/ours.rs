//! Which files in a run's folder are the run's own: what removes files removes no others.

use crate::atomic::io_error;
use crate::error::StoreError;
use crate::lock::LOCK_FILE;
use rrf_files::is_staged_name;
use std::path::{Path, PathBuf};

/// Whether a path, relative to the run's folder, is one that a run writes.
pub fn is_run_file(relative: &Path) -> bool {
    let parts: Option<Vec<&str>> = relative.iter().map(|part| part.to_str()).collect();
    let Some(parts) = parts else {
        return false;
    };
    if parts.last().is_some_and(|name| is_staged_name(name)) {
        return true;
    }
    match parts.as_slice() {
        [name] => ["run.json", LOCK_FILE].contains(name),
        ["model", table] => has_ending(table, ".arrow"),
        ["test", part] => is_part(part),
        ["samples", cell, part] => is_numbered(cell, "cell=", "") && is_part(part),
        ["rounds", round, rest @ ..] if is_numbered(round, "", "") => match rest {
            [name] => ["plan.json", "judged.json", "seconds.json", "tasks.parquet"].contains(name),
            ["tasks", name] => is_numbered(name, "", ".json"),
            ["fits", cell, table] => is_numbered(cell, "cell=", "") && has_ending(table, ".arrow"),
            _ => false,
        },
        _ => false,
    }
}

fn is_part(name: &str) -> bool {
    is_numbered(name, "part-", ".parquet")
}

fn has_ending(name: &str, ending: &str) -> bool {
    name.strip_suffix(ending)
        .is_some_and(|stem| !stem.is_empty())
}

fn is_numbered(name: &str, before: &str, after: &str) -> bool {
    let number = name
        .strip_prefix(before)
        .and_then(|name| name.strip_suffix(after));
    number.is_some_and(|n| !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit()))
}

/// Files below some folders of a run that are not the run's; links are not followed.
///
/// # Errors
/// [`StoreError::Io`].
pub fn files_of_others(run: &Path, folders: &[&str]) -> Result<Vec<PathBuf>, StoreError> {
    let mut found = Vec::new();
    for folder in folders {
        collect(run, &run.join(folder), &mut found)?;
    }
    found.sort();
    Ok(found)
}

fn collect(run: &Path, folder: &Path, found: &mut Vec<PathBuf>) -> Result<(), StoreError> {
    let entries = match std::fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(()),
        Err(e) => return Err(io_error(folder, "read", e)),
    };
    for entry in entries {
        let entry = entry.map_err(|e| io_error(folder, "read", e))?;
        let kind = entry.file_type().map_err(|e| io_error(folder, "read", e))?;
        let path = entry.path();
        let is_own = path.strip_prefix(run).is_ok_and(is_run_file);
        if kind.is_dir() {
            collect(run, &path, found)?;
        } else if !(kind.is_file() && is_own) {
            found.push(path);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn own_names_are_known() {
        for own in [
            "run.json",
            "lock",
            "model/tree.arrow",
            "samples/cell=000042/part-00000.parquet",
            "test/part-00001.parquet",
            "rounds/000/plan.json",
            "rounds/012/tasks/00000.json",
            "rounds/000/fits/cell=000003/weights.arrow",
            "staging/cell=000001-part-00000.0.tmp",
            "rounds/000/.plan.json.3.tmp",
        ] {
            assert!(is_run_file(Path::new(own)), "{own}");
        }
        for other in [
            "notes.txt",
            "samples/notes.txt",
            "samples/cell=000042/part-00000.parquet.bak",
            "samples/cell=x/part-00000.parquet",
            "model/.arrow",
            "rounds/first/plan.json",
            "rounds/000/fits/cell=000003/more/weights.arrow",
            "",
        ] {
            assert!(!is_run_file(Path::new(other)), "{other}");
        }
    }
}
