//! Settings of a transfer, from those of a bake.

use crate::error::BakeError;
use crate::settings::{Preset, Settings};
use rrf_extract::{ExtractError, NarrowLight, Region, check_box};
use rrf_scene::{LightUnits, LoadOptions, Scene, SkyOption};
use rrf_transfer::TransferConfig;
use serde::{Deserialize, Serialize};

/// Says in `run.json` that a run is a transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Told {
    /// A transfer.
    Transfer,
}

/// The settings of a transfer's bake, recorded in `run.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TransferBakeConfig {
    pub(crate) method: Told,
    /// The preset that the others started from.
    pub preset: Preset,
    /// Relative error to reach.
    pub target: f32,
    /// Reflectance of surfaces without a material.
    pub default_albedo: f32,
    /// Unit of glTF light intensities.
    pub light_units: LightUnits,
    /// Sky of a scene whose file has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sky: Option<SkyOption>,
    /// Box in which movable lights are expected.
    pub light_box: Option<Region>,
    /// Box that eyes may be in.
    pub eye_box: Option<Region>,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Patches of the surface.
    pub patches: usize,
    /// Rows that are traced before any cell errs.
    pub rows: usize,
    /// Paths of a row.
    pub paths: u32,
    /// Treatment of narrow parts' light. Scenes without narrow parts say nothing of it.
    #[serde(default, skip_serializing_if = "NarrowLight::is_learned")]
    pub narrow: NarrowLight,
    /// Further rounds of rows at most.
    pub rounds: u32,
    /// Share of the light that the clusters which a cell reads may leave out.
    pub cluster_error: f64,
    /// Hidden units of nets.
    pub units: usize,
    /// Point lights of the ensemble.
    pub points: usize,
    /// Suns of the ensemble.
    pub suns: usize,
    /// Smooth skies of the ensemble.
    pub skies: usize,
}

impl TransferBakeConfig {
    /// A preset's settings.
    pub fn preset(preset: Preset, seed: u64) -> TransferBakeConfig {
        let plain = TransferConfig::default();
        let (patches, rows, paths, rounds, cluster_error, lights) = match preset {
            Preset::Preview => (500, 6_000, 128, 0, 0.01, [100, 32, 8]),
            Preset::Standard => (2_000, 30_000, 256, 0, 0.003, [200, 64, 16]),
            Preset::Fine => (8_000, 120_000, 256, 3, 0.002, [300, 96, 24]),
        };
        let [points, suns, skies] = lights;
        TransferBakeConfig {
            method: Told::Transfer,
            preset,
            target: 0.05,
            default_albedo: 0.7,
            light_units: LightUnits::Spec,
            sky: None,
            light_box: None,
            eye_box: None,
            seed,
            patches,
            rows,
            paths,
            narrow: NarrowLight::Learned,
            rounds,
            cluster_error,
            units: plain.net.units,
            points,
            suns,
            skies,
        }
    }

    /// Configuration of the library that bakes transfers.
    pub(crate) fn plan(&self) -> TransferConfig {
        let mut plan = TransferConfig {
            seed: self.seed,
            rows: self.rows,
            rounds: self.rounds,
            target: self.target,
            cluster_error: self.cluster_error,
            ..TransferConfig::default()
        };
        plan.patches.count = self.patches;
        plan.paths.paths = self.paths;
        plan.paths.broad = !self.narrow.is_learned();
        plan.net.units = self.units;
        plan.pilot_rows = plan.pilot_rows.min(self.rows);
        plan
    }

    /// About as many bytes as its rows take where one surface has all of them, which are held together: the
    /// candidates of each, what it sends on, and what it gets of each light (measured: 6.3 kB by `preview`).
    pub fn most_memory(&self) -> u64 {
        let lights = self.points + self.suns + self.skies;
        self.rows as u64 * (2_048 + 30 * lights as u64)
    }

    /// The options that the scene file is read with.
    pub fn load_options(&self) -> LoadOptions {
        LoadOptions {
            default_albedo: self.default_albedo,
            light_units: self.light_units,
            sky: self.sky.clone(),
        }
    }
}

impl Settings {
    /// Configuration that the settings give for a transfer of a scene.
    ///
    /// # Errors
    /// [`BakeError::Setting`] for options that a transfer has no use for,
    /// [`BakeError::Extract`] for a box outside of the scene or a scene without surfaces.
    pub fn transfer_config(&self, scene: &Scene) -> Result<TransferBakeConfig, BakeError> {
        let mut config = TransferBakeConfig::preset(self.preset, self.seed);
        config.target = self.target;
        config.default_albedo = self.scene.default_albedo;
        config.light_units = self.scene.light_units;
        config.sky = self.scene.sky_option();
        config.light_box = self.light_box;
        config.eye_box = self.eye_box;
        config.narrow = NarrowLight::of(scene);
        config.rows = self.rows.map_or(config.rows, |rows| rows as usize);
        config.paths = self.paths.unwrap_or(config.paths);
        if !config.paths.is_multiple_of(2) {
            let odd = config.paths;
            let reason =
                format!("{odd} paths a row: has to be even, since rows are kept as two halves");
            return Err(wrong("--paths", reason));
        }
        config.rounds = self.rounds.map_or(config.rounds, |rounds| rounds - 1);
        config.units = match self.hidden.as_ref().map(|hidden| hidden.0.as_slice()) {
            None => config.units,
            Some(&[units]) => units,
            Some(_) => {
                let reason = "nets of the method transfer, the default, have one hidden layer: give one \
                              number, or --method nets";
                return Err(wrong("--hidden", reason.into()));
            }
        };
        let cells = "the method transfer, the default, cuts as many cells as its rows fill";
        refuse("--cells", self.cells.is_some(), cells)?;
        refuse("--most-cells", self.most_cells.is_some(), cells)?;
        let inputs = "nets of the method transfer, the default, see position, normal and viewer, and no light";
        refuse("--inputs", self.inputs.is_some(), inputs)?;
        let trim = "nets of the method transfer, the default, keep their size";
        refuse("--no-trim", !self.trim, trim)?;
        let bounds = scene.bounds().ok_or(ExtractError::NoTriangle)?;
        for (what, of) in [("light", self.light_box), ("eye", self.eye_box)] {
            if let Some(region) = of {
                check_box(region, what, &bounds)?;
            }
        }
        Ok(config)
    }
}

/// Refuses an option that only the other methods have.
fn refuse(option: &str, is_given: bool, reason: &str) -> Result<(), BakeError> {
    match is_given {
        true => Err(wrong(
            option,
            format!("{reason}. The option is for --method nets and its baselines"),
        )),
        false => Ok(()),
    }
}

fn wrong(option: &str, reason: String) -> BakeError {
    BakeError::Setting {
        option: option.into(),
        reason,
    }
}
