//! Continuing a run with other settings.

use crate::error::BakeError;
use crate::plan::round::RoundPlan;
use crate::run::folder::Run;
use crate::run::json::{read_json, remove_file, remove_folder};
use crate::run::manifest::manifest;
use crate::settings::BakeConfig;
use rrf_scene::Scene;
use rrf_store::layout::round_folder;
use rrf_store::lock::FolderLock;
use rrf_store::manifest::RunManifest;
use rrf_store::ours::files_of_others;
use rrf_store::parts::remove_part;
use std::collections::BTreeSet;
use std::path::Path;

/// Folders of a run.
pub(crate) const ALL: [&str; 4] = ["model", "samples", "test", "rounds"];

/// Removes folders of a run, in which there is nothing else.
pub(crate) fn remove_own(folder: &Path, gone: &[&str]) -> Result<(), BakeError> {
    let others = files_of_others(folder, gone)?;
    if !others.is_empty() {
        return Err(BakeError::NotOurs {
            path: folder.into(),
            others,
        });
    }
    for name in gone {
        remove_folder(&folder.join(name))?;
    }
    Ok(())
}

impl Run {
    /// Prepares a folder to be resumed with these settings: removes what depends on a difference and
    /// keeps the rest. Another scene, seed, program or setting of the extraction leaves nothing.
    /// Other settings leave the samples of the first round and all fits, which tasks with the same
    /// inputs find done. A folder without a run is left alone.
    ///
    /// # Errors
    /// [`BakeError::NotOurs`] where a file would be removed that no run writes: nothing is removed
    /// then. [`BakeError::Store`].
    pub fn renew(folder: &Path, scene: &Scene, config: &BakeConfig) -> Result<(), BakeError> {
        if !RunManifest::path(folder).exists() {
            return Ok(());
        }
        let _lock = FolderLock::take(folder)?;
        let found = RunManifest::read(folder)?;
        let asked = manifest(scene, config)?;
        if found.asks_for_the_same(&asked) {
            return Ok(());
        }
        let same = found.facts() == asked.facts()
            && found.config.get("extract") == asked.config.get("extract")
            && found.created_by == asked.created_by;
        remove_own(folder, if same { &["model"] } else { &ALL })?;
        if same {
            retire_plans(folder, &found.hash(folder)?)?;
        }
        Ok(asked.write(folder)?)
    }
}

/// Removes the plan and evaluation of every round, and the samples that the first round does not
/// have. Plans are made again, and their tasks are found done where nothing changed. Works from the last
/// round down, so that a removal that was interrupted is completed by the next one.
fn retire_plans(folder: &Path, hash: &str) -> Result<(), BakeError> {
    let read = |round: u32| {
        let path = round_folder(folder, round).join("plan.json");
        read_json::<RoundPlan>(&path, hash)
    };
    let Some(first) = read(0)? else {
        return Ok(());
    };
    let first: BTreeSet<_> = first.part_ids().collect();
    let mut rounds = 0;
    while round_folder(folder, rounds).exists() {
        rounds += 1;
    }
    for round in (0..rounds).rev() {
        let plan = read(round)?;
        let parts = plan.iter().flat_map(RoundPlan::part_ids);
        for [cell, part] in parts.filter(|part| !first.contains(part)) {
            remove_part(folder, cell, part)?;
        }
        for name in ["judged.json", "seconds.json", "tasks.parquet", "plan.json"] {
            remove_file(&round_folder(folder, round).join(name))?;
        }
        remove_folder(&round_folder(folder, round).join("tasks"))?;
    }
    Ok(())
}
