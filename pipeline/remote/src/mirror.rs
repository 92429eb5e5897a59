//! A folder of this machine that is kept the same as a folder of a store.

use crate::error::RemoteError;
use crate::remote::Remote;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard};
use std::time::SystemTime;

/// What changes: the files of the model, which later rounds replace, the times of a round, which its stages
/// add to, and the plan of a round whose smaller nets are taken back. All others are written once.
const MODEL: &str = "model/";
const REPLACED: [&str; 3] = ["/seconds.json", "/tasks.parquet", "/plan.json"];
const CHAPTERS: &str = "/tasks/";
/// What a run's other files belong to.
const MANIFEST: &str = "run.json";
/// What marks a round as planned, trained or committed comes after what it speaks of.
const LAST: [&str; 3] = ["tasks.parquet", "plan.json", "judged.json"];

/// A folder and the store's. The store is the truth: the folder is a copy of this process alone.
#[derive(Debug)]
pub struct Mirror {
    folder: PathBuf,
    remote: Remote,
    /// Files that are the same on both sides, and when they were written here.
    same: Mutex<BTreeMap<String, SystemTime>>,
}

impl Mirror {
    /// Of the folder at `address`, in `folder`.
    pub fn open(address: &str, folder: &Path) -> Result<Mirror, RemoteError> {
        Ok(Mirror {
            folder: folder.into(),
            remote: Remote::open(address)?,
            same: Mutex::new(BTreeMap::new()),
        })
    }

    /// The folder of this machine.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Makes the folder what the store has, all of it: what a copy of earlier holds beside that
    /// goes, so that nothing comes back that others have removed since. A copy of another run at
    /// the same address goes whole.
    pub fn pull(&self) -> Result<(), RemoteError> {
        let there = self.remote.list()?;
        let manifest = self.folder.join(MANIFEST);
        if fs::read(&manifest).ok() != self.remote.get(MANIFEST)? {
            remove(&self.folder, fs::remove_dir_all(&self.folder))?;
        }
        let mut here = Vec::new();
        list(&self.folder, "", &mut here)?;
        for name in here
            .iter()
            .filter(|name| there.binary_search(name).is_err())
        {
            let path = self.folder.join(name);
            remove(&path, fs::remove_file(&path))?;
        }
        self.fetch(there)
    }

    /// Fetches those of the store's files that `wanted` names.
    pub fn pull_some(&self, wanted: impl Fn(&str) -> bool) -> Result<(), RemoteError> {
        self.fetch(
            self.remote
                .list()?
                .into_iter()
                .filter(|name| wanted(name))
                .collect(),
        )
    }

    fn fetch(&self, names: Vec<String>) -> Result<(), RemoteError> {
        let mut same = self.same();
        for name in names {
            let path = self.folder.join(&name);
            if (changes(&name) || !path.exists())
                && let Some(bytes) = self.remote.get(&name)?
            {
                write(&path, &bytes)?;
            }
            if let Some(written) = written(&path)? {
                same.insert(name, written);
            }
        }
        Ok(())
    }

    /// Stores what this machine has and the store does not, and removes there what was the same
    /// on both sides and is gone here.
    pub fn push(&self) -> Result<(), RemoteError> {
        let mut same = self.same();
        let mut names = Vec::new();
        list(&self.folder, "", &mut names)?;
        names.sort_by_key(|name| (order(name), name.clone()));
        for name in &names {
            let path = self.folder.join(name);
            // another thread's file may have been renamed, or removed by a commit, meanwhile
            let Some(now) = written(&path)? else {
                continue;
            };
            if same
                .get(name)
                .is_some_and(|then| !changes(name) || *then == now)
            {
                continue;
            }
            let bytes = fs::read(&path).map_err(|source| io(&path, "read", source))?;
            if changes(name) {
                self.remote.put(name, bytes)?;
            } else {
                self.remote.put_new(name, bytes)?;
            }
            same.insert(name.clone(), now);
        }
        let here: BTreeSet<&String> = names.iter().collect();
        let gone: Vec<String> = same
            .keys()
            .filter(|name| !here.contains(name))
            .cloned()
            .collect();
        for name in gone {
            self.remote.remove(&name)?;
            same.remove(&name);
        }
        Ok(())
    }

    fn same(&self) -> MutexGuard<'_, BTreeMap<String, SystemTime>> {
        // what a panicking thread left is still a set of names that were stored
        self.same
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner())
    }
}

fn changes(name: &str) -> bool {
    let replaced = REPLACED.iter().any(|end| name.ends_with(end));
    replaced || name.starts_with(MODEL) || name.contains(CHAPTERS)
}

fn order(name: &str) -> usize {
    let last = LAST.iter().position(|end| name.ends_with(end));
    last.map_or(0, |place| place + 1)
}

/// Files below a folder, but for unfinished ones.
fn list(root: &Path, folder: &str, names: &mut Vec<String>) -> Result<(), RemoteError> {
    let path = root.join(folder);
    let entries = match fs::read_dir(&path) {
        Ok(entries) => entries,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
        Err(source) => return Err(io(&path, "read", source)),
    };
    for entry in entries {
        let entry = entry.map_err(|source| io(&path, "read", source))?;
        let Ok(name) = entry.file_name().into_string() else {
            continue;
        };
        let inner = match folder.is_empty() {
            true => name.clone(),
            false => format!("{folder}/{name}"),
        };
        if entry.path().is_dir() {
            if inner != "staging" {
                list(root, &inner, names)?;
            }
        } else if !name.ends_with(".tmp") && inner != "lock" {
            names.push(inner);
        }
    }
    Ok(())
}

/// When a file was written; none where it is not there.
fn written(path: &Path) -> Result<Option<SystemTime>, RemoteError> {
    match fs::metadata(path).and_then(|meta| meta.modified()) {
        Ok(time) => Ok(Some(time)),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        Err(source) => Err(io(path, "read", source)),
    }
}

/// What is gone already was removed.
fn remove(path: &Path, removed: std::io::Result<()>) -> Result<(), RemoteError> {
    match removed {
        Err(source) if source.kind() != ErrorKind::NotFound => Err(io(path, "remove", source)),
        _ => Ok(()),
    }
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), RemoteError> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(|source| io(folder, "create the folder", source))?;
    }
    let name = path
        .file_name()
        .and_then(|name| name.to_str())
        .unwrap_or_default();
    let staged = path.with_file_name(format!(".{name}.{}.tmp", std::process::id()));
    fs::write(&staged, bytes).map_err(|source| io(&staged, "write", source))?;
    fs::rename(&staged, path).map_err(|source| io(path, "write", source))
}

fn io(path: &Path, action: &'static str, source: std::io::Error) -> RemoteError {
    RemoteError::Io {
        path: path.into(),
        action,
        source,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mirrors(base: &Path) -> [Mirror; 2] {
        fs::create_dir(base.join("store")).unwrap();
        let address = format!("file://{}/store", base.display());
        ["a", "b"].map(|name| Mirror::open(&address, &base.join(name)).unwrap())
    }

    fn put(mirror: &Mirror, name: &str, text: &str) {
        write(&mirror.folder().join(name), text.as_bytes()).unwrap();
    }

    fn text(mirror: &Mirror, name: &str) -> Option<String> {
        fs::read_to_string(mirror.folder().join(name)).ok()
    }

    #[test]
    fn what_one_machine_stores_another_fetches() {
        let base = tempfile::tempdir().unwrap();
        let [a, b] = mirrors(base.path());
        put(&a, "run.json", "{}");
        put(&a, "samples/cell=000000/part-00000.parquet", "rows");
        put(&a, "model/weights.arrow", "first");
        put(&a, "rounds/000/plan.json", "all trimmed");
        put(&a, "rounds/000/tasks/00000.json", "all trimmed");
        put(&a, "staging/x.0.tmp", "half");
        put(&a, "rounds/000/.plan.json.0.tmp", "half");
        a.push().unwrap();
        b.pull().unwrap();
        assert_eq!(
            text(&b, "samples/cell=000000/part-00000.parquet").unwrap(),
            "rows"
        );
        assert_eq!(text(&b, "staging/x.0.tmp"), None);
        assert_eq!(text(&b, "rounds/000/.plan.json.0.tmp"), None);
        // the model is replaced, and a plan; a part that a round has taken apart goes
        put(&a, "model/weights.arrow", "second");
        put(&a, "rounds/000/plan.json", "some taken back");
        put(&a, "rounds/000/tasks/00000.json", "some taken back");
        fs::remove_file(a.folder().join("samples/cell=000000/part-00000.parquet")).unwrap();
        a.push().unwrap();
        b.pull().unwrap();
        assert_eq!(text(&b, "model/weights.arrow").unwrap(), "second");
        for name in ["plan.json", "tasks/00000.json"] {
            let plan = text(&b, &format!("rounds/000/{name}"));
            assert_eq!(plan.unwrap(), "some taken back", "{name}");
        }
        assert_eq!(
            b.remote.list().unwrap(),
            [
                "model/weights.arrow",
                "rounds/000/plan.json",
                "rounds/000/tasks/00000.json",
                "run.json"
            ]
        );
    }

    /// A copy that another process left: parts that were taken apart since are not stored again,
    /// and nothing of another run at the same address is taken for this one's.
    #[test]
    fn the_store_is_the_truth() {
        let base = tempfile::tempdir().unwrap();
        let [a, b] = mirrors(base.path());
        put(&a, "run.json", "one");
        a.push().unwrap();
        put(&b, "run.json", "one");
        put(
            &b,
            "samples/cell=000000/part-00000.parquet",
            "taken apart since",
        );
        b.pull().unwrap();
        b.push().unwrap();
        assert_eq!(b.remote.list().unwrap(), ["run.json"]);

        put(&b, "run.json", "of a run that was there before");
        put(&b, "model/weights.arrow", "of that run");
        b.pull().unwrap();
        assert_eq!(text(&b, "run.json").unwrap(), "one");
        assert_eq!(text(&b, "model/weights.arrow"), None);
    }

    /// What has not changed is not sent again.
    #[test]
    fn a_model_is_stored_once_a_round() {
        let base = tempfile::tempdir().unwrap();
        let [a, b] = mirrors(base.path());
        put(&a, "model/weights.arrow", "first");
        a.push().unwrap();
        // put there by another: an unneeded push would bring the first back
        b.remote
            .put("model/weights.arrow", b"another's".to_vec())
            .unwrap();
        a.push().unwrap();
        let stored = b.remote.get("model/weights.arrow").unwrap().unwrap();
        assert_eq!(stored, b"another's");
        put(&a, "model/weights.arrow", "second");
        a.push().unwrap();
        let stored = b.remote.get("model/weights.arrow").unwrap().unwrap();
        assert_eq!(stored, b"second");
    }

    #[test]
    fn of_two_writers_one_wins() {
        let base = tempfile::tempdir().unwrap();
        let [a, b] = mirrors(base.path());
        for mirror in [&a, &b] {
            put(mirror, "rounds/000/fits/cell=000000/weights.arrow", "same");
        }
        a.push().unwrap();
        b.push().unwrap();
        put(&a, "run.json", "one");
        put(&b, "run.json", "two");
        a.push().unwrap();
        let error = b.push().unwrap_err();
        assert!(matches!(error, RemoteError::Differs { .. }), "{error}");
        assert_eq!(b.remote.get("run.json").unwrap().unwrap(), b"one");
    }

    #[test]
    fn strange_addresses() {
        for address in ["s4://bucket/run", "run", "s3:///"] {
            assert!(Remote::open(address).is_err(), "{address}");
        }
        assert!(crate::is_url(Path::new("s3://bucket/run")));
        assert!(!crate::is_url(Path::new("runs/s3")));
    }
}
