//! An open run folder.

use crate::error::BakeError;
use crate::policy::tasks::RunInputs;
use crate::run::json::corrupt;
use crate::run::manifest::{expect_same, expect_scene, manifest, to_value};
use crate::run::method::RunMethod;
use crate::settings::BakeConfig;
use rrf_scene::Scene;
use rrf_store::layout::round_folder;
use rrf_store::lock::FolderLock;
use rrf_store::manifest::{RunFacts, RunManifest};
use rrf_store::model;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// An open run folder.
#[derive(Clone, Debug)]
pub struct Run {
    /// The folder.
    pub folder: PathBuf,
    /// `run.json`.
    pub manifest: RunManifest,
    /// The settings in it.
    pub config: BakeConfig,
    /// Keeps other processes from working on the folder.
    pub(crate) lock: Option<Arc<FolderLock>>,
}

impl Run {
    /// Starts a run, or opens the same one to continue it. No other process can begin, continue or
    /// commit it until the run is dropped or this process ends.
    ///
    /// # Errors
    /// [`StoreError::Busy`](rrf_store::StoreError::Busy) where another process works on it;
    /// [`BakeError::Extract`] for settings that the scene does not allow, [`BakeError::Exists`] for
    /// an existing run where `resume` is not set, [`BakeError::OtherRun`] where it was started with
    /// another scene or other settings, [`BakeError::Store`].
    pub fn create(
        folder: &Path,
        scene: &Scene,
        config: &BakeConfig,
        resume: bool,
    ) -> Result<Run, BakeError> {
        // before anything is written: a folder with a manifest counts as a run
        config.validate(scene)?;
        let mut run = Run::unwritten(folder, scene, config)?;
        run.lock = Some(FolderLock::take(folder)?);
        if !run.exists() {
            run.manifest.write(folder)?;
            return Ok(run);
        }
        if !resume {
            return Err(BakeError::Exists {
                path: folder.into(),
            });
        }
        let found = Run::open(folder)?;
        let settings = to_value(&found.config)?;
        expect_same(folder, (&found.manifest, &settings), &run.manifest)?;
        Ok(Run {
            lock: run.lock,
            ..found
        })
    }

    /// A run with these settings, of which nothing is written yet.
    pub(crate) fn unwritten(
        folder: &Path,
        scene: &Scene,
        config: &BakeConfig,
    ) -> Result<Run, BakeError> {
        Ok(Run {
            folder: folder.into(),
            manifest: manifest(scene, config)?,
            config: config.clone(),
            lock: None,
        })
    }

    /// Opens an existing run to work on it, as [`Run::create`] does.
    ///
    /// # Errors
    /// [`BakeError::Store`], [`StoreError::Busy`](rrf_store::StoreError::Busy) among it.
    pub fn open_to_work(folder: &Path) -> Result<Run, BakeError> {
        // a folder without a run gets no lock
        RunManifest::read(folder)?;
        let lock = FolderLock::take(folder)?;
        Ok(Run {
            lock: Some(lock),
            ..Run::open(folder)?
        })
    }

    /// Opens an existing run to read it, or to do one of its tasks: any number of processes may.
    ///
    /// # Errors
    /// [`BakeError::Store`]; [`BakeError::Method`] where it is no run of nets.
    pub fn open(folder: &Path) -> Result<Run, BakeError> {
        let manifest = RunManifest::read(folder)?;
        if RunMethod::told(&manifest) == RunMethod::Transfer {
            return Err(BakeError::Method {
                path: folder.into(),
                found: "transfer",
                needed: "nets",
            });
        }
        let config = serde_json::from_value(manifest.config.clone())
            .map_err(|error| corrupt(&RunManifest::path(folder), error))?;
        Ok(Run {
            folder: folder.into(),
            manifest,
            config,
            lock: None,
        })
    }

    /// Reads the scene of the run again and checks it against the run's hash.
    ///
    /// # Errors
    /// [`BakeError::Scene`], [`BakeError::OtherRun`].
    pub fn load_scene(&self) -> Result<Scene, BakeError> {
        let scene = rrf_scene::load(&self.manifest.scene, &self.config.load_options())?;
        expect_scene(&self.folder, &self.manifest, &scene)?;
        Ok(scene)
    }

    /// The hash that the run's JSON files and model go by.
    ///
    /// # Errors
    /// [`BakeError::Store`].
    pub(crate) fn hash(&self) -> Result<String, BakeError> {
        Ok(self.manifest.hash(&self.folder)?)
    }

    /// The facts that every table of the run has to agree with.
    pub fn facts(&self) -> RunFacts {
        self.manifest.facts()
    }

    /// What task hashes depend on besides a plan.
    pub(crate) fn inputs(&self) -> RunInputs<'_> {
        RunInputs {
            manifest: &self.manifest,
            config: &self.config,
        }
    }

    /// Whether the folder holds a run.
    pub(crate) fn exists(&self) -> bool {
        RunManifest::path(&self.folder).exists()
    }

    /// Passes on a result unless the folder has disappeared meanwhile: what was written then is lost,
    /// and what was not found proves nothing.
    pub(crate) fn unless_gone<T>(&self, result: Result<T, BakeError>) -> Result<T, BakeError> {
        match self.exists() {
            true => result,
            false => Err(BakeError::Gone {
                path: self.folder.clone(),
            }),
        }
    }

    /// Whether all tables of the model exist, whole and of this run.
    ///
    /// # Errors
    /// [`BakeError::Store`] where they cannot be read.
    pub(crate) fn has_model(&self) -> Result<bool, BakeError> {
        let facts = self.facts();
        let model = model::read_model(&self.folder, &facts);
        match model.and_then(|_| model::read_metrics(&self.folder, &facts)) {
            Ok(_) => Ok(true),
            Err(error) if error.is_damage() => Ok(false),
            Err(error) => Err(error.into()),
        }
    }

    /// The path of a file of a round.
    pub(crate) fn round_file(&self, round: u32, name: &str) -> PathBuf {
        round_folder(&self.folder, round).join(name)
    }
}
