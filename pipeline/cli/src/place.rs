//! Where a run lies: a folder, or an object store with a copy on this machine.

use rrf_remote::{Mirror, is_url};
use std::path::{Path, PathBuf};

/// A run's folder on this machine.
pub struct Place {
    folder: PathBuf,
    mirror: Option<Mirror>,
}

/// What looking at a run needs.
pub fn model(name: &str) -> bool {
    name == "run.json" || name.starts_with("model/")
}

impl Place {
    /// The folder named, or a copy of what an address holds of the files that `wanted` names.
    pub fn open(path: &Path, wanted: impl Fn(&str) -> bool) -> anyhow::Result<Place> {
        if !is_url(path) {
            return Ok(Place {
                folder: path.into(),
                mirror: None,
            });
        }
        let address = path.to_string_lossy();
        let mirror = Mirror::open(&address, &copies()?.join(name(&address)))?;
        mirror.pull(wanted)?;
        Ok(Place {
            folder: mirror.folder().into(),
            mirror: Some(mirror),
        })
    }

    /// Fetches more files of an address.
    pub fn pull(&self, wanted: impl Fn(&str) -> bool) -> anyhow::Result<()> {
        Ok(self.mirror.as_ref().map_or(Ok(()), |m| m.pull(wanted))?)
    }

    /// Stores what changed, where the run has an address.
    pub fn push(&self) -> anyhow::Result<()> {
        Ok(self.mirror.as_ref().map_or(Ok(()), Mirror::push)?)
    }

    /// The folder on this machine.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The copy, where the run has an address.
    pub fn into_mirror(self) -> Option<Mirror> {
        self.mirror
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
