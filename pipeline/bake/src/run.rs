//! The run folder: what it belongs to, and where its files lie.

use crate::commit::places;
use crate::config::BakeConfig;
use crate::decide::Stop;
use crate::error::BakeError;
use crate::job::Chapter;
use crate::judge::Judgement;
use crate::plan::RoundPlan;
use crate::remedy::Remedy;
use crate::task::{chapters, task_rows};
use crate::work::Site;
use rrf_extract::ExtractError;
use rrf_scene::Scene;
use rrf_store::StoreError;
use rrf_store::atomic::{atomic_write, create_folder};
use rrf_store::layout::{chapter_path, model_folder, round_folder, task_table_path};
use rrf_store::manifest::{FORMAT, RunFacts, RunManifest};
use rrf_store::parts::remove_part;
use rrf_store::task_table::write_tasks;
use rrf_trace::Tracer;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// How a round was judged and whether it was the last.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Judged {
    /// The round.
    pub round: u32,
    /// Its errors.
    pub judgement: Judgement,
    /// Why no further round is made; none where one is.
    pub stop: Option<Stop>,
    /// What could be done about the cells that miss the target.
    #[serde(default)]
    pub remedies: Vec<Remedy>,
}

/// An open run folder.
#[derive(Clone, Debug)]
pub struct Run {
    /// The folder.
    pub folder: PathBuf,
    /// `run.json`.
    pub manifest: RunManifest,
    /// Its settings.
    pub config: BakeConfig,
}

impl Run {
    /// Begins a run, or goes on with the same one.
    ///
    /// # Errors
    /// [`BakeError::Extract`] for settings that no scene or not this one allows,
    /// [`BakeError::Exists`] where a run lies and `resume` is not set, [`BakeError::OtherRun`]
    /// where it was begun with another scene or other settings, [`BakeError::Store`].
    pub fn create(
        folder: &Path,
        scene: &Scene,
        config: &BakeConfig,
        resume: bool,
    ) -> Result<Run, BakeError> {
        // before anything is written: a folder with a manifest counts as a run
        let bounds = scene.bounds().ok_or(ExtractError::NoTriangle)?;
        config.extract.validate(&bounds)?;
        let manifest = manifest(scene, config)?;
        if RunManifest::path(folder).exists() {
            if !resume {
                return Err(BakeError::Exists {
                    path: folder.into(),
                });
            }
            let found = Run::open(folder)?;
            found.expect_same(&manifest)?;
            return Ok(found);
        }
        if config.extract.eye_box.is_some() {
            let scene = scene.unlit();
            Site::new(&scene, &Tracer::new(&scene)?, config)?;
        }
        manifest.write(folder)?;
        Ok(Run {
            folder: folder.into(),
            manifest,
            config: config.clone(),
        })
    }

    /// A run of these settings that is in no folder.
    pub(crate) fn unwritten(scene: &Scene, config: &BakeConfig) -> Result<Run, BakeError> {
        Ok(Run {
            folder: PathBuf::new(),
            manifest: manifest(scene, config)?,
            config: config.clone(),
        })
    }

    /// Makes a folder ready to be resumed with these settings: where it was begun with others,
    /// what depends on the difference goes and the rest stays. Another scene, seed, program or
    /// setting of the extraction leaves nothing; other settings leave the first round's samples
    /// and all fits, which tasks of the same inputs find done. A folder without a run is left
    /// alone.
    pub fn renew(folder: &Path, scene: &Scene, config: &BakeConfig) -> Result<(), BakeError> {
        if !RunManifest::path(folder).exists() {
            return Ok(());
        }
        let found = RunManifest::read(folder)?;
        let asked = manifest(scene, config)?;
        if found == asked {
            return Ok(());
        }
        let same = found.facts() == asked.facts()
            && found.config.get("extract") == asked.config.get("extract")
            && found.created_by == asked.created_by;
        let gone: &[&str] = if same {
            &["model"]
        } else {
            &["model", "samples", "test", "rounds"]
        };
        for name in gone {
            remove_folder(&folder.join(name))?;
        }
        if same {
            retire_plans(folder)?;
        }
        Ok(asked.write(folder)?)
    }

    /// Opens a run that exists.
    pub fn open(folder: &Path) -> Result<Run, BakeError> {
        let manifest = RunManifest::read(folder)?;
        let config = serde_json::from_value(manifest.config.clone())
            .map_err(|error| corrupt(&RunManifest::path(folder), error.to_string()))?;
        Ok(Run {
            folder: folder.into(),
            manifest,
            config,
        })
    }

    /// The scene of the run, read again and checked against the run's hash.
    pub fn load_scene(&self) -> Result<Scene, BakeError> {
        let scene = rrf_scene::load(&self.manifest.scene, &self.config.load_options())?;
        let asked = scene.hash_hex();
        if asked != self.manifest.scene_hash {
            return Err(BakeError::OtherRun {
                path: self.folder.clone(),
                what: "scene: the file has changed since the bake",
                found: self.manifest.scene_hash.clone(),
                asked,
            });
        }
        Ok(scene)
    }

    /// The plan of a round, or none where it has not been made.
    pub fn read_plan(&self, round: u32) -> Result<Option<RoundPlan>, BakeError> {
        let path = self.round_file(round, "plan.json");
        let plan: Option<RoundPlan> = read_json(&path)?;
        if let Some(plan) = &plan {
            plan.check().map_err(|reason| corrupt(&path, reason))?;
        }
        Ok(plan)
    }

    /// Writes a round's tasks, then its plan: a round that has a plan is whole.
    pub fn write_plan(&self, plan: &RoundPlan) -> Result<(), BakeError> {
        let path = task_table_path(&self.folder, plan.round);
        create_folder(&round_folder(&self.folder, plan.round))?;
        let chapters = chapters(self, plan)?;
        for (number, chapter) in (0u32..).zip(&chapters) {
            write_new_json(&chapter_path(&self.folder, plan.round, number), chapter)?;
        }
        let facts = self.facts();
        write_tasks(&path, &task_rows(&chapters, facts.seed), &facts)?;
        // of another plan of this round
        remove_file(&self.round_file(plan.round, "judged.json"))?;
        remove_file(&crate::seconds::path(self, plan.round))?;
        write_json(&self.round_file(plan.round, "plan.json"), plan)
    }

    /// Some of a round's tasks with what they need, or none where the file is not there.
    pub(crate) fn read_chapter(
        &self,
        round: u32,
        number: u32,
    ) -> Result<Option<Chapter>, BakeError> {
        read_json(&chapter_path(&self.folder, round, number))
    }

    /// How a round was judged, or none where it has not been committed.
    pub fn read_judged(&self, round: u32) -> Result<Option<Judged>, BakeError> {
        read_json(&self.round_file(round, "judged.json"))
    }

    /// Marks a round as committed.
    pub fn write_judged(&self, judged: &Judged) -> Result<(), BakeError> {
        write_json(&self.round_file(judged.round, "judged.json"), judged)
    }

    /// The result of some work, unless the folder has gone meanwhile: what was written then went
    /// elsewhere, and what was not found says nothing.
    pub(crate) fn unless_gone<T>(&self, result: Result<T, BakeError>) -> Result<T, BakeError> {
        match self.is_there() {
            true => result,
            false => Err(BakeError::Gone {
                path: self.folder.clone(),
            }),
        }
    }

    /// Whether the folder still is the run's.
    pub(crate) fn is_there(&self) -> bool {
        RunManifest::path(&self.folder).exists()
    }

    /// Whether all tables of a model are there.
    pub fn has_model(&self) -> bool {
        let folder = model_folder(&self.folder);
        ["tree", "weights", "metrics"]
            .iter()
            .all(|table| folder.join(format!("{table}.arrow")).exists())
    }

    fn round_file(&self, round: u32, name: &str) -> PathBuf {
        round_folder(&self.folder, round).join(name)
    }

    /// What every table of the run has to agree with.
    pub fn facts(&self) -> RunFacts {
        self.manifest.facts()
    }

    fn expect_same(&self, asked: &RunManifest) -> Result<(), BakeError> {
        let differ = |what, found: String, asked: String| {
            Err(BakeError::OtherRun {
                path: self.folder.clone(),
                what,
                found,
                asked,
            })
        };
        let found = &self.manifest;
        // its tasks have other names, and its rows may be other rows
        if found.created_by != asked.created_by {
            return differ(
                "program",
                found.created_by.clone(),
                asked.created_by.clone(),
            );
        }
        if found.scene_hash != asked.scene_hash {
            return differ("scene", found.scene_hash.clone(), asked.scene_hash.clone());
        }
        if found.seed != asked.seed {
            return differ("seed", found.seed.to_string(), asked.seed.to_string());
        }
        // as parsed: settings that are younger than the run have their defaults
        let config = serde_json::to_value(&self.config)
            .map_err(|error| corrupt(Path::new("run.json"), error.to_string()))?;
        if config != asked.config {
            let (found, asked) = differences(&config, &asked.config);
            return differ("configuration", found, asked);
        }
        Ok(())
    }
}

/// Removes every round's plan and judgement, and the samples that the first round does not have:
/// the plans are made anew, and what they ask for again is found done. From the last round down, so that
/// what is left of a removal cut off halfway is found again.
fn retire_plans(folder: &Path) -> Result<(), BakeError> {
    let read = |round: u32| read_json::<RoundPlan>(&round_folder(folder, round).join("plan.json"));
    let Some(first) = read(0)? else {
        return Ok(());
    };
    let first: BTreeSet<_> = places(&first).collect();
    let mut rounds = 0;
    while round_folder(folder, rounds).exists() {
        rounds += 1;
    }
    for round in (0..rounds).rev() {
        let plan = read(round)?;
        let placed = plan.iter().flat_map(places);
        for [cell, part] in placed.filter(|place| !first.contains(place)) {
            remove_part(folder, cell, part)?;
        }
        for name in ["judged.json", "tasks.parquet", "plan.json"] {
            remove_file(&round_folder(folder, round).join(name))?;
        }
        remove_folder(&round_folder(folder, round).join("tasks"))?;
    }
    Ok(())
}

fn remove_file(path: &Path) -> Result<(), StoreError> {
    removed(path, std::fs::remove_file(path))
}

fn remove_folder(path: &Path) -> Result<(), StoreError> {
    removed(path, std::fs::remove_dir_all(path))
}

fn removed(path: &Path, result: std::io::Result<()>) -> Result<(), StoreError> {
    match result {
        Err(source) if source.kind() != ErrorKind::NotFound => Err(StoreError::Io {
            path: path.into(),
            action: "remove",
            source,
        }),
        _ => Ok(()),
    }
}

pub(crate) fn read_json<T: serde::de::DeserializeOwned>(
    path: &Path,
) -> Result<Option<T>, BakeError> {
    let text = match std::fs::read(path) {
        Ok(text) => text,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        Err(source) => {
            return Err(StoreError::Io {
                path: path.into(),
                action: "read",
                source,
            }
            .into());
        }
    };
    let value = serde_json::from_slice(&text).map_err(|error| corrupt(path, error.to_string()))?;
    Ok(Some(value))
}

pub(crate) fn write_json(path: &Path, value: &impl Serialize) -> Result<(), BakeError> {
    let mut text = serde_json::to_vec(value).map_err(|error| corrupt(path, error.to_string()))?;
    text.push(b'\n');
    if let Some(folder) = path.parent() {
        create_folder(folder)?;
    }
    Ok(atomic_write(path, &text)?)
}

/// [`write_json`] where the file is not there with these bytes already.
fn write_new_json(path: &Path, value: &impl Serialize) -> Result<(), BakeError> {
    let mut text = serde_json::to_vec(value).map_err(|error| corrupt(path, error.to_string()))?;
    text.push(b'\n');
    if std::fs::read(path).is_ok_and(|found| found == text) {
        return Ok(());
    }
    if let Some(folder) = path.parent() {
        create_folder(folder)?;
    }
    Ok(atomic_write(path, &text)?)
}

/// The settings that differ, `extract.rows 2000, extract.paths 4`, on both sides.
fn differences(found: &Value, asked: &Value) -> (String, String) {
    let (mut a, mut b) = (BTreeMap::new(), BTreeMap::new());
    settings(found, String::new(), &mut a);
    settings(asked, String::new(), &mut b);
    let one_side = |of: &BTreeMap<String, String>, other: &BTreeMap<String, String>| {
        let differing = of.iter().filter(|(name, x)| other.get(*name) != Some(x));
        let named: Vec<String> = differing.map(|(name, x)| format!("{name} {x}")).collect();
        named.join(", ")
    };
    (one_side(&a, &b), one_side(&b, &a))
}

/// Every setting by its dotted name; lists are one setting.
fn settings(value: &Value, name: String, to: &mut BTreeMap<String, String>) {
    let Value::Object(fields) = value else {
        to.insert(name, value.to_string());
        return;
    };
    for (field, value) in fields {
        let dot = if name.is_empty() { "" } else { "." };
        settings(value, format!("{name}{dot}{field}"), to);
    }
}

fn corrupt(path: &Path, reason: String) -> StoreError {
    StoreError::Corrupt {
        path: path.into(),
        format: "JSON",
        reason,
        remedy: "Bake into a new folder",
    }
}

fn manifest(scene: &Scene, config: &BakeConfig) -> Result<RunManifest, BakeError> {
    let light_box = config.extract.light_box;
    let (low, high) = (light_box.minimum, light_box.maximum);
    let seed = config.extract.seed;
    let source = std::path::absolute(&scene.source).unwrap_or_else(|_| scene.source.clone());
    let config = serde_json::to_value(config)
        .map_err(|error| corrupt(Path::new("run.json"), error.to_string()))?;
    Ok(RunManifest {
        format: FORMAT,
        created_by: format!("rrf {}", env!("CARGO_PKG_VERSION")),
        scene: source,
        scene_hash: scene.hash_hex(),
        seed,
        light_box: [low[0], low[1], low[2], high[0], high[1], high[2]],
        config,
    })
}
