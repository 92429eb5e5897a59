//! JSON files of a run.

use crate::error::BakeError;
use rrf_store::StoreError;
use rrf_store::atomic::{atomic_write, create_folder};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::io::ErrorKind;
use std::path::Path;

/// The last field of every object: blake3 of the object without it and the hash of the run.
const HASH: &str = "blake3";

/// Most bytes of a file.
const MAX_BYTES: u64 = 4 << 30;

/// Reads a file of the run with this hash; none where it does not exist.
///
/// # Errors
/// [`StoreError::Corrupt`] where a bit of it has changed, or it is of another run.
pub(crate) fn read_json<T: DeserializeOwned>(
    path: &Path,
    run: &str,
) -> Result<Option<T>, BakeError> {
    match rrf_files::read_regular(path, MAX_BYTES) {
        Ok(text) => {
            let text = unhashed(&text, run).map_err(|hash| {
                corrupt(
                    path,
                    format!("its content does not have the hash {hash} in it"),
                )
            })?;
            let value = serde_json::from_slice(&text).map_err(|error| corrupt(path, error))?;
            Ok(Some(value))
        }
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        Err(error) => Err(io_error(path, "read", error).into()),
    }
}

/// Writes a file where it does not exist with the same bytes already.
pub(crate) fn write_json(path: &Path, value: &impl Serialize, run: &str) -> Result<(), BakeError> {
    let text = serde_json::to_vec(value).map_err(|error| corrupt(path, error))?;
    let text = hashed(text, run);
    if std::fs::read(path).is_ok_and(|found| found == text) {
        return Ok(());
    }
    if let Some(folder) = path.parent() {
        create_folder(folder)?;
    }
    Ok(atomic_write(path, &text)?)
}

/// The text of an object with its hash, and a line's end.
fn hashed(mut text: Vec<u8>, run: &str) -> Vec<u8> {
    let hash = hash_of(&text, run);
    text.pop();
    let comma = if text.len() > 1 { "," } else { "" };
    text.extend_from_slice(comma.as_bytes());
    text.extend_from_slice(end_with(&hash).as_bytes());
    text
}

/// The text without its hash; as it is where it has none, as one that a person wrote. The error
/// is the hash that the content does not have.
fn unhashed(text: &[u8], run: &str) -> Result<Vec<u8>, String> {
    let Some(written) = hash_in(text) else {
        return Ok(text.to_vec());
    };
    let end = end_with(&written).len();
    let kept = text.get(..text.len() - end).unwrap_or_default();
    let mut kept = kept.strip_suffix(b",").unwrap_or(kept).to_vec();
    kept.push(b'}');
    match hash_of(&kept, run) == written {
        true => Ok(kept),
        false => Err(written),
    }
}

fn hash_of(text: &[u8], run: &str) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(text).update(run.as_bytes());
    hasher.finalize().to_hex().to_string()
}

/// The hash at a text's end.
pub(crate) fn hash_in(text: &[u8]) -> Option<String> {
    let length = end_with(&"0".repeat(64)).len();
    let end = text.get(text.len().checked_sub(length)?..)?;
    let hash = std::str::from_utf8(end).ok()?;
    let hash = hash.get(length - 64 - 3..length - 3)?.to_owned();
    (end_with(&hash).as_bytes() == end).then_some(hash)
}

fn end_with(hash: &str) -> String {
    format!("\"{HASH}\":\"{hash}\"}}\n")
}

/// Removes a file, should it exist.
pub(crate) fn remove_file(path: &Path) -> Result<(), StoreError> {
    removed(path, std::fs::remove_file(path))
}

/// Removes a folder with everything in it, should it exist.
pub(crate) fn remove_folder(path: &Path) -> Result<(), StoreError> {
    removed(path, std::fs::remove_dir_all(path))
}

fn removed(path: &Path, result: std::io::Result<()>) -> Result<(), StoreError> {
    match result {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(io_error(path, "remove", error)),
        _ => Ok(()),
    }
}

fn io_error(path: &Path, action: &'static str, source: std::io::Error) -> StoreError {
    StoreError::Io {
        path: path.into(),
        action,
        source,
    }
}

/// The error of a file whose content is wrong.
pub(crate) fn corrupt(path: &Path, reason: impl ToString) -> StoreError {
    StoreError::Corrupt {
        path: path.into(),
        format: "JSON",
        reason: reason.to_string(),
        remedy: "Bake into a new folder",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    #[test]
    fn every_changed_bit_is_found_or_harmless() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.json");
        for value in [BTreeMap::new(), BTreeMap::from([("a".to_owned(), 1)])] {
            write_json(&path, &value, "run").unwrap();
            let text = std::fs::read(&path).unwrap();
            assert!(hash_in(&text).is_some());
            let read = || read_json::<BTreeMap<String, serde_json::Value>>(&path, "run");
            let mut read_back = read().unwrap().unwrap();
            assert_eq!(read_back.len(), value.len());
            for bit in 0..8 * text.len() {
                let mut flipped = text.clone();
                flipped[bit / 8] ^= 1 << (bit % 8);
                std::fs::write(&path, &flipped).unwrap();
                if let Ok(Some(found)) = read() {
                    let same = value
                        .iter()
                        .all(|(k, v)| found.get(k) == Some(&(*v).into()));
                    assert!(same, "bit {bit}: {found:?}");
                }
            }
            std::fs::write(&path, &text).unwrap();
            let foreign = read_json::<BTreeMap<String, serde_json::Value>>(&path, "another");
            assert!(foreign.is_err());
            read_back.insert("b".into(), 2.into());
            std::fs::write(&path, serde_json::to_vec_pretty(&read_back).unwrap()).unwrap();
            assert_eq!(read().unwrap().unwrap(), read_back);
        }
    }
}
