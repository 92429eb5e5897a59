//! Where a run lies: a folder, or an object store with a copy on this machine.

use rrf_remote::{Mirror, RemoteError, is_url};
use std::path::{Path, PathBuf};

/// A run's folder on this machine.
pub struct Place {
    folder: PathBuf,
    mirror: Option<Mirror>,
    /// Whether the copy is of no use afterwards.
    passing: bool,
}

impl Place {
    /// To bake in: all files. One process at a time works on a copy of this kind.
    pub fn whole(path: &Path) -> anyhow::Result<Place> {
        let place = Place::open(path, "")?;
        place.mirror.as_ref().map_or(Ok(()), Mirror::pull)?;
        Ok(place)
    }

    /// To look at: the manifest and the model.
    pub fn model(path: &Path) -> anyhow::Result<Place> {
        let place = Place::passing(path, "view")?;
        place.pull(|name| name == "run.json" || name.starts_with("model/"))?;
        Ok(place)
    }

    /// To do one task in, beside any number of others: no files yet.
    pub fn task(path: &Path) -> anyhow::Result<Place> {
        Place::passing(path, "task")
    }

    fn passing(path: &Path, purpose: &str) -> anyhow::Result<Place> {
        let mut place = Place::open(path, &format!("-{purpose}-{}", std::process::id()))?;
        place.passing = place.mirror.is_some();
        Ok(place)
    }

    fn open(path: &Path, purpose: &str) -> anyhow::Result<Place> {
        let mirror = match is_url(path) {
            true => {
                let address = path.to_string_lossy();
                let copy = copies()?.join(name(&address) + purpose);
                Some(Mirror::open(&address, &copy)?)
            }
            false => None,
        };
        Ok(Place {
            folder: mirror.as_ref().map_or(path, Mirror::folder).into(),
            mirror,
            passing: false,
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

impl Drop for Place {
    fn drop(&mut self) {
        if self.passing {
            // what is left of a copy is in nobody's way
            let _ = std::fs::remove_dir_all(&self.folder);
        }
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
