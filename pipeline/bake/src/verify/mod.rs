//! Whether every file of a run is the one that was written.
//!
//! [`verify`] reads all tables and JSON files with their hashes, holds them against the plans and
//! the model against the fits that it is made of, and says of every damage what mends it.

mod found;
mod model;
mod rounds;
mod samples;
mod transfer;

pub use found::Damage;

use crate::error::BakeError;
use crate::run::folder::Run;
use found::{Found, text};
use rrf_files::is_staged_name;
use rrf_store::lock::LOCK_FILE;
use rrf_store::manifest::RunManifest;
use rrf_store::{StoreError, layout};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// The state of a run's files.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Verification {
    /// Files of the run that were read.
    pub files: usize,
    /// Their sizes together \[bytes\].
    pub bytes: u64,
    /// Rounds that have a plan.
    pub rounds: u32,
    /// Tasks of the last round that are not done, a transfer that is not baked counts as one; the run is
    /// unfinished where there are any.
    pub open_tasks: usize,
    /// Files that are not what was written, or are gone.
    pub damages: Vec<Damage>,
    /// Files that no run has, and that nothing reads.
    pub unknown: Vec<PathBuf>,
}

/// Reads and checks every file of a run.
///
/// # Errors
/// [`BakeError::Store`] where the folder holds no run or cannot be read.
pub fn verify(folder: &Path) -> Result<Verification, BakeError> {
    let mut verification = Verification::default();
    let mut found = Found::default();
    // whether every file of the run is known by now
    let mut knows_all = false;
    let manifest = RunManifest::path(folder);
    found
        .known
        .extend([manifest.clone(), folder.join(LOCK_FILE)]);
    match Run::open(folder) {
        Err(BakeError::Store(missing @ StoreError::NotARun { .. })) => return Err(missing.into()),
        Err(BakeError::Method { .. }) => {
            verification.open_tasks = usize::from(!transfer::check(folder, &mut found)?);
            knows_all = true;
        }
        Err(error) => found.damage(
            &manifest,
            text(&error),
            "Restore it from a backup: all other files are read by it. Or bake into a new folder",
        ),
        Ok(run) => {
            let rounds = rounds::check(&run, &mut found)?;
            verification.rounds = rounds.plans.len() as u32;
            knows_all = verification.rounds > 0;
            verification.open_tasks = samples::check(&run, &rounds, &mut found)?;
            model::check(&run, &rounds, &mut found)?;
        }
    }
    let mut files = Vec::new();
    list(folder, &mut files)?;
    for (path, size) in files {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if found.known.contains(&path) {
            verification.files += 1;
            verification.bytes += size;
        } else if path.starts_with(layout::samples_folder(folder)) {
            let remedy = "Move it elsewhere: readers of the dataset would take it for samples";
            found.damage(&path, "it is in no plan of the run", remedy);
        } else if !is_staged_name(&name) && knows_all {
            verification.unknown.push(path);
        }
    }
    verification.damages = found.damages;
    verification.damages.sort();
    verification.unknown.sort();
    Ok(verification)
}

/// All files below a folder with their sizes; links are not followed.
fn list(folder: &Path, files: &mut Vec<(PathBuf, u64)>) -> Result<(), BakeError> {
    let fail = |source| StoreError::Io {
        path: folder.into(),
        action: "read",
        source,
    };
    for entry in std::fs::read_dir(folder).map_err(fail)? {
        let entry = entry.map_err(fail)?;
        let found = entry.metadata().map_err(fail)?;
        match found.is_dir() {
            true => list(&entry.path(), files)?,
            false => files.push((entry.path(), found.len())),
        }
    }
    Ok(())
}
