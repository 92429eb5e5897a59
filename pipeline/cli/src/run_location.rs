//! Location of a run: a folder, or an object store with a copy on this machine.

use crate::failure::BadInput;
use anyhow::Context;
use rrf_remote::{Mirror, RemoteError, is_url};
use rrf_store::lock::FolderLock;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tempfile::TempDir;

/// A run's folder on this machine.
pub struct RunLocation {
    folder: PathBuf,
    mirror: Option<Mirror>,
    /// A copy that is of no use afterwards, and goes.
    _passing: Option<TempDir>,
    /// Keeps other processes from the copy.
    _lock: Option<Arc<FolderLock>>,
}

impl RunLocation {
    /// To look at: all files of a run that is there.
    pub fn existing(path: &Path) -> anyhow::Result<RunLocation> {
        expect_run(path)?;
        RunLocation::whole(path)
    }

    /// To bake in: all files. One process at a time works on a copy of this kind.
    pub fn whole(path: &Path) -> anyhow::Result<RunLocation> {
        let mut place = RunLocation::open(path, |folder| Ok((folder.to_path_buf(), None)))?;
        if let Some(mirror) = &place.mirror {
            // beside the copy, which fetching may replace whole
            let beside = place.folder.with_extension("lock");
            place._lock = Some(FolderLock::take(&beside)?);
            mirror.pull()?;
        }
        Ok(place)
    }

    /// To look at: the manifest and the model.
    pub fn model(path: &Path) -> anyhow::Result<RunLocation> {
        let place = RunLocation::passing(path, "view")?;
        place.pull(|name| name == "run.json" || name.starts_with("model/"))?;
        Ok(place)
    }

    /// To do one task in, beside any number of others: no files yet.
    pub fn task(path: &Path) -> anyhow::Result<RunLocation> {
        RunLocation::passing(path, "task")
    }

    /// In a new folder that no other process has, whatever machines share the copies.
    fn passing(path: &Path, purpose: &str) -> anyhow::Result<RunLocation> {
        RunLocation::open(path, |folder| {
            let (parent, name) = (folder.parent(), folder.file_name());
            let parent = parent.unwrap_or(folder);
            let name = name.unwrap_or_default().to_string_lossy();
            std::fs::create_dir_all(parent)
                .with_context(|| format!("{}: cannot be created", parent.display()))?;
            let own = tempfile::Builder::new()
                .prefix(&format!("{name}-{purpose}-"))
                .tempdir_in(parent)
                .with_context(|| format!("{}: no folder can be made in it", parent.display()))?;
            Ok((own.path().to_path_buf(), Some(own)))
        })
    }

    /// `copy` makes the folder of a copy from the one that the address alone would have.
    fn open(
        path: &Path,
        copy: impl Fn(&Path) -> anyhow::Result<(PathBuf, Option<TempDir>)>,
    ) -> anyhow::Result<RunLocation> {
        if !is_url(path) {
            return Ok(RunLocation {
                folder: path.into(),
                mirror: None,
                _passing: None,
                _lock: None,
            });
        }
        let address = path.to_string_lossy();
        let (folder, passing) = copy(&copies()?.join(name(&address)))?;
        Ok(RunLocation {
            mirror: Some(Mirror::open(&address, &folder)?),
            folder,
            _passing: passing,
            _lock: None,
        })
    }

    /// Fetches files of an address.
    pub fn pull(&self, wanted: impl Fn(&str) -> bool) -> anyhow::Result<()> {
        Ok(self
            .mirror
            .as_ref()
            .map_or(Ok(()), |m| m.pull_some(wanted))?)
    }

    /// Stores what changed, where the run has an address.
    pub fn push(&self) -> Result<(), RemoteError> {
        self.mirror.as_ref().map_or(Ok(()), Mirror::push)
    }

    /// The folder on this machine.
    pub fn folder(&self) -> &Path {
        &self.folder
    }
}

/// Says what a file is where a run's folder should be.
pub fn expect_run(path: &Path) -> Result<(), BadInput> {
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    let is_scene = ["pbrt", "gltf", "glb", "obj"].contains(&ending.to_ascii_lowercase().as_str());
    match path.is_file() {
        true if is_scene => Err(BadInput(format!(
            "{path}: this is a scene: bake it first (rrf bake {path} -o RUN) and name the run's folder",
            path = path.display()
        ))),
        _ => Ok(()),
    }
}

/// `RRF_CACHE`, or the user's cache folder.
fn copies() -> anyhow::Result<PathBuf> {
    let folder = |name: &str| {
        std::env::var_os(name)
            .filter(|v| !v.is_empty())
            .map(PathBuf::from)
    };
    folder("RRF_CACHE")
        .or_else(|| folder("XDG_CACHE_HOME").map(|cache| cache.join("rrf")))
        .or_else(|| folder("HOME").map(|home| home.join(".cache/rrf")))
        .ok_or_else(|| anyhow::anyhow!("no folder for copies of stored runs: set RRF_CACHE"))
}

/// The address as a folder's name: readable, and different for every address.
fn name(address: &str) -> String {
    let fine = |c: char| if c.is_ascii_alphanumeric() { c } else { '-' };
    let text: String = address.chars().map(fine).collect();
    let hash = blake3::hash(address.as_bytes()).to_hex();
    let end: String = hash.chars().take(12).collect();
    format!("{text}-{end}")
}
