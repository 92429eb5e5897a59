//! The folder of a transfer's run.

use super::config::TransferBakeConfig;
use super::read;
use super::summary::{TransferFacts, TransferSummary};
use crate::error::BakeError;
use crate::run::json::corrupt;
use crate::run::manifest::{asked_manifest, expect_same, expect_scene};
use crate::run::method::RunMethod;
use crate::run::renew::{ALL, remove_own};
use rrf_scene::Scene;
use rrf_store::lock::FolderLock;
use rrf_store::manifest::{RunFacts, RunManifest};
use rrf_store::model::read_transfer;
use rrf_transfer::TransferModel;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// An open run of a transfer.
#[derive(Clone, Debug)]
pub struct TransferRun {
    /// The folder.
    pub folder: PathBuf,
    /// `run.json`.
    pub manifest: RunManifest,
    /// The settings in it.
    pub config: TransferBakeConfig,
    /// Keeps other processes from working on the folder.
    _lock: Option<Arc<FolderLock>>,
}

impl TransferRun {
    /// Starts a run, or opens the same one to continue it, as [`crate::Run::create`] does.
    ///
    /// # Errors
    /// [`BakeError::Store`], [`BakeError::Exists`], [`BakeError::OtherRun`],
    /// [`BakeError::Extract`].
    pub(super) fn create(
        folder: &Path,
        scene: &Scene,
        config: &TransferBakeConfig,
        resume: bool,
    ) -> Result<TransferRun, BakeError> {
        let asked = manifest(scene, config)?;
        let lock = Some(FolderLock::take(folder)?);
        if !RunManifest::path(folder).exists() {
            asked.write(folder)?;
            return Ok(TransferRun {
                folder: folder.into(),
                manifest: asked,
                config: config.clone(),
                _lock: lock,
            });
        }
        if !resume {
            return Err(BakeError::Exists {
                path: folder.into(),
            });
        }
        let found = TransferRun::open(folder)?;
        expect_same(folder, (&found.manifest, &to_value(&found.config)?), &asked)?;
        Ok(TransferRun {
            _lock: lock,
            ..found
        })
    }

    /// Prepares a folder to be resumed with these settings: a run of others, or of another method, leaves
    /// nothing. A folder without a run is left alone.
    ///
    /// # Errors
    /// As [`crate::Run::renew`].
    pub fn renew(
        folder: &Path,
        scene: &Scene,
        config: &TransferBakeConfig,
    ) -> Result<(), BakeError> {
        if !RunManifest::path(folder).exists() {
            return Ok(());
        }
        let _lock = FolderLock::take(folder)?;
        let asked = manifest(scene, config)?;
        if RunManifest::read(folder)?.asks_for_the_same(&asked) {
            return Ok(());
        }
        remove_own(folder, &ALL)?;
        Ok(asked.write(folder)?)
    }

    /// Opens an existing run to read it.
    ///
    /// # Errors
    /// [`BakeError::Store`], [`BakeError::Method`] where it is no transfer.
    pub fn open(folder: &Path) -> Result<TransferRun, BakeError> {
        let manifest = RunManifest::read(folder)?;
        if RunMethod::told(&manifest) != RunMethod::Transfer {
            return Err(BakeError::Method {
                path: folder.into(),
                found: "nets",
                needed: "transfer",
            });
        }
        let config = serde_json::from_value(manifest.config.clone())
            .map_err(|error| corrupt(&RunManifest::path(folder), error))?;
        Ok(TransferRun {
            folder: folder.into(),
            manifest,
            config,
            _lock: None,
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

    /// The facts that every table of the run has to agree with.
    pub fn facts(&self) -> RunFacts {
        self.manifest.facts()
    }

    /// Reads the model, and what its cells do not say; `unlit` is the run's scene
    /// without its own lights.
    ///
    /// # Errors
    /// [`BakeError::Store`] where it is not there, damaged, of another run or of another scene.
    pub fn model(&self, unlit: &Scene) -> Result<(TransferModel, TransferFacts), BakeError> {
        let tables = read_transfer(&self.folder, &self.facts())?;
        let facts = read::facts(&tables.whole);
        let broad = !self.config.narrow.is_learned();
        Ok((read::model(&self.folder, unlit, tables, broad)?, facts))
    }

    /// Reads the model and sums it up.
    ///
    /// # Errors
    /// As [`TransferRun::model`].
    pub fn summary(&self, unlit: &Scene) -> Result<TransferSummary, BakeError> {
        let (model, facts) = self.model(unlit)?;
        Ok(TransferSummary::new(&model, facts, self.config.target))
    }
}

/// The manifest of a transfer's bake. Where no light box is given it is the scene's bounds.
fn manifest(scene: &Scene, config: &TransferBakeConfig) -> Result<RunManifest, BakeError> {
    let bounds = scene
        .bounds()
        .ok_or(rrf_extract::ExtractError::NoTriangle)?;
    let (low, high) = match config.light_box {
        Some(region) => (region.minimum, region.maximum),
        None => (bounds.min, bounds.max),
    };
    let light_box = [low[0], low[1], low[2], high[0], high[1], high[2]];
    Ok(asked_manifest(
        scene,
        config.seed,
        light_box,
        to_value(config)?,
    ))
}

fn to_value(config: &TransferBakeConfig) -> Result<serde_json::Value, BakeError> {
    let value = serde_json::to_value(config);
    Ok(value.map_err(|error| corrupt(Path::new("run.json"), error))?)
}
