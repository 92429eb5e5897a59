//! The run folder: what it belongs to, and where its files lie.

use crate::config::BakeConfig;
use crate::error::BakeError;
use rrf_extract::{ExtractError, Plan};
use rrf_scene::Scene;
use rrf_store::StoreError;
use rrf_store::atomic::atomic_write;
use rrf_store::manifest::{FORMAT, RunFacts, RunManifest};
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

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
        manifest.write(folder)?;
        Ok(Run {
            folder: folder.into(),
            manifest,
            config: config.clone(),
        })
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

    /// `plan.json`, or none where the plan has not been made.
    pub fn read_plan(&self) -> Result<Option<Plan>, BakeError> {
        let path = self.plan_path();
        let text = match std::fs::read(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            Err(source) => {
                return Err(StoreError::Io {
                    path,
                    action: "read",
                    source,
                }
                .into());
            }
        };
        let plan: Plan =
            serde_json::from_slice(&text).map_err(|error| corrupt(&path, error.to_string()))?;
        plan.check().map_err(|reason| corrupt(&path, reason))?;
        Ok(Some(plan))
    }

    /// The plan of a run that has been extracted.
    pub fn plan(&self) -> Result<Plan, BakeError> {
        let missing = || BakeError::NotExtracted {
            path: self.folder.clone(),
            cell: 0,
        };
        self.read_plan()?.ok_or_else(missing)
    }

    /// Writes `plan.json`.
    pub fn write_plan(&self, plan: &Plan) -> Result<(), BakeError> {
        let path = self.plan_path();
        let mut text =
            serde_json::to_vec(plan).map_err(|error| corrupt(&path, error.to_string()))?;
        text.push(b'\n');
        Ok(atomic_write(&path, &text)?)
    }

    fn plan_path(&self) -> PathBuf {
        self.folder.join("plan.json")
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
        if found.scene_hash != asked.scene_hash {
            return differ("scene", found.scene_hash.clone(), asked.scene_hash.clone());
        }
        if found.seed != asked.seed {
            return differ("seed", found.seed.to_string(), asked.seed.to_string());
        }
        if found.config != asked.config {
            let (found, asked) = differences(&found.config, &asked.config);
            return differ("configuration", found, asked);
        }
        Ok(())
    }
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
