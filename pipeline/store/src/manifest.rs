//! `RUN/run.json`: what a run folder belongs to and how it was asked for.

use crate::atomic::{atomic_write, create_folder, io_error};
use crate::error::StoreError;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Version of `run.json` and of the folder's layout.
pub const FORMAT: u32 = 1;

const LIMIT: u64 = 16 << 20;
const REMEDY: &str = "Bake into a new folder";

/// What every table of a run must agree with.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RunFacts {
    /// blake3 of what the scene file means, 64 hexadecimal digits.
    pub scene_hash: String,
    /// Seed of every random number.
    pub seed: u64,
}

/// What the last bits of a run's numbers depend on beside its settings.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Kernels {
    /// The linear algebra library, its version and the kernels that it chose.
    pub linear_algebra: String,
    /// The widest vector instructions that loops are compiled for and the processor has.
    pub vectors: String,
}

/// A run as a person asked for it, with every setting as it was used.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunManifest {
    /// [`FORMAT`].
    pub format: u32,
    /// Program and version, `rrf 0.2.0`.
    pub created_by: String,
    /// The scene file as it was named.
    pub scene: PathBuf,
    /// blake3 of what the scene file means, 64 hexadecimal digits.
    pub scene_hash: String,
    /// Seed of every random number.
    pub seed: u64,
    /// Where lights may be: least x y z, greatest x y z \[m\], world frame.
    pub light_box: [f32; 6],
    /// Every other setting, as the stages take them.
    pub config: serde_json::Value,
    /// Those of the process that began the run; none in runs of earlier versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kernels: Option<Kernels>,
}

impl RunManifest {
    /// Where the manifest of a run lies.
    pub fn path(run: &Path) -> PathBuf {
        run.join("run.json")
    }

    /// The facts that tables repeat.
    pub fn facts(&self) -> RunFacts {
        RunFacts {
            scene_hash: self.scene_hash.clone(),
            seed: self.seed,
        }
    }

    /// blake3 of everything that a model depends on, 64 hexadecimal digits: all but the place of the
    /// scene file, and the kernels, which decide no more than the last bits.
    ///
    /// # Errors
    /// [`StoreError::Corrupt`] for settings that are no JSON.
    pub fn hash(&self, run: &Path) -> Result<String, StoreError> {
        let placeless = RunManifest {
            scene: PathBuf::new(),
            kernels: None,
            ..self.clone()
        };
        let text = serde_json::to_vec(&placeless);
        let text = text.map_err(|e| corrupt(&RunManifest::path(run), e))?;
        Ok(blake3::hash(&text).to_hex().to_string())
    }

    /// Whether another manifest asks for the same, on whatever processor.
    pub fn asks_for_the_same(&self, other: &RunManifest) -> bool {
        let kernels = other.kernels.clone();
        *other
            == RunManifest {
                kernels,
                ..self.clone()
            }
    }

    /// Writes `RUN/run.json`, making the folder where missing.
    ///
    /// # Errors
    /// [`StoreError::Io`]; [`StoreError::Corrupt`] for values that could not be read back.
    pub fn write(&self, run: &Path) -> Result<(), StoreError> {
        let path = RunManifest::path(run);
        self.validate(&path)?;
        let mut text = serde_json::to_vec_pretty(self).map_err(|e| corrupt(&path, e))?;
        text.push(b'\n');
        create_folder(run)?;
        atomic_write(&path, &text)
    }

    /// Reads `RUN/run.json`.
    ///
    /// # Errors
    /// [`StoreError::NotARun`] without one, [`StoreError::Version`], [`StoreError::Corrupt`].
    pub fn read(run: &Path) -> Result<RunManifest, StoreError> {
        let path = RunManifest::path(run);
        let text = rrf_files::read_regular(&path, LIMIT).map_err(|e| match e.kind() {
            ErrorKind::NotFound | ErrorKind::NotADirectory => {
                StoreError::NotARun { path: run.into() }
            }
            _ => io_error(&path, "read", e),
        })?;
        let value: serde_json::Value =
            serde_json::from_slice(&text).map_err(|e| corrupt(&path, e))?;
        let format = value.get("format").cloned().unwrap_or_default();
        if format != FORMAT {
            return Err(StoreError::Version {
                path,
                table: "run.json",
                expected: FORMAT,
                found: format.to_string(),
                remedy: REMEDY,
            });
        }
        let manifest: RunManifest = serde_json::from_value(value).map_err(|e| corrupt(&path, e))?;
        manifest.validate(&path)?;
        Ok(manifest)
    }

    /// Checks that a run belongs to the scene and seed at hand.
    ///
    /// # Errors
    /// [`StoreError::Foreign`] naming both.
    pub fn expect(&self, run: &Path, facts: &RunFacts) -> Result<(), StoreError> {
        self.facts().expect(&RunManifest::path(run), facts)
    }

    fn validate(&self, path: &Path) -> Result<(), StoreError> {
        let [x0, y0, z0, x1, y1, z1] = self.light_box;
        let ordered = x0 <= x1 && y0 <= y1 && z0 <= z1;
        if !ordered || !self.light_box.iter().all(|x| x.is_finite()) {
            let found = self.light_box.map(|x| x.to_string()).join(",");
            return Err(corrupt(path, format!("light_box {found} is no box")));
        }
        if self.scene_hash.len() != 64 || !self.scene_hash.bytes().all(|b| b.is_ascii_hexdigit()) {
            return Err(corrupt(path, "scene_hash is not 64 hexadecimal digits"));
        }
        Ok(())
    }
}

impl RunFacts {
    /// Checks that these facts, found in `path`, are those expected.
    ///
    /// # Errors
    /// [`StoreError::Foreign`] naming both.
    pub fn expect(&self, path: &Path, expected: &RunFacts) -> Result<(), StoreError> {
        let foreign = |fact, expected: String, found: String| StoreError::Foreign {
            path: path.into(),
            fact,
            expected,
            found,
            remedy: "The folder belongs to another run: choose another folder",
        };
        if self.scene_hash != expected.scene_hash {
            let (expected, found) = (expected.scene_hash.clone(), self.scene_hash.clone());
            return Err(foreign("scene hash", expected, found));
        }
        if self.seed != expected.seed {
            let (expected, found) = (expected.seed.to_string(), self.seed.to_string());
            return Err(foreign("seed", expected, found));
        }
        Ok(())
    }
}

fn corrupt(path: &Path, reason: impl ToString) -> StoreError {
    StoreError::Corrupt {
        path: path.into(),
        format: "run.json",
        reason: reason.to_string(),
        remedy: REMEDY,
    }
}
