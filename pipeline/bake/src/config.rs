//! Every setting of a bake, recorded in `run.json`.

use rrf_extract::{ExtractConfig, Region, Weights};
use rrf_scene::{LightUnits, LoadOptions};
use rrf_train::{LmConfig, Precision, TrainConfig};
use serde::{Deserialize, Serialize};

/// How much work a bake does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Preset {
    /// Seconds: to see whether a scene and a light box make sense.
    Preview,
    /// Minutes: what the README's figures are made with.
    Standard,
    /// As long as it takes.
    Fine,
}

/// Settings of all stages.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BakeConfig {
    /// What the settings came from.
    pub preset: Preset,
    /// Relative error to reach.
    pub target: f32,
    /// Reflectance of surfaces without a material.
    pub default_albedo: f32,
    /// Unit of glTF light intensities.
    pub light_units: LightUnits,
    /// Rounds at the most.
    pub rounds: u32,
    /// Cells at the most, after all rounds.
    pub most_cells: u32,
    /// Nets lose what they can do without once the target is met.
    #[serde(default)]
    pub trim: bool,
    /// Plan and extraction.
    pub extract: ExtractConfig,
    /// Training.
    pub train: TrainConfig,
}

impl BakeConfig {
    /// A preset's settings.
    pub fn preset(preset: Preset, light_box: Region, seed: u64) -> BakeConfig {
        let (cells, rows, paths, rounds, most_cells) = match preset {
            Preset::Preview => (16, 40_000, 64, 1, 16),
            Preset::Standard => (8, 50_000, 128, 32, 1000),
            Preset::Fine => (32, 300_000, 128, 48, 4096),
        };
        let small_cells = preset != Preset::Preview;
        let mut train = TrainConfig {
            seed,
            drop_redundant: small_cells,
            exponential: true,
            precision: Precision::Single,
            lm: LmConfig {
                reuse: 4,
                ..LmConfig::default()
            },
            ..TrainConfig::default()
        };
        if small_cells {
            train
                .inputs
                .retain(|name| !WAY_TO_LIGHT.contains(&name.as_str()));
        }
        BakeConfig {
            preset,
            target: 0.05,
            default_albedo: 0.7,
            light_units: LightUnits::Spec,
            rounds,
            most_cells,
            trim: true,
            extract: ExtractConfig {
                light_box,
                eye_box: None,
                seed,
                candidates: 65_536,
                cells,
                rows,
                fewest_rows: 1_000,
                paths,
                weights: Weights::default(),
            },
            train,
        }
    }

    /// How the scene file is read.
    pub fn load_options(&self) -> LoadOptions {
        LoadOptions {
            default_albedo: self.default_albedo,
            light_units: self.light_units,
        }
    }
}

/// In cells as small as splits make them a net has these from the point and the light; they do not earn
/// their keep (docs/accuracy.md).
const WAY_TO_LIGHT: [&str; 4] = ["dx", "dy", "dz", "inv_distance"];
