//! The settings of a bake, described once: [`Settings`] is what a user may ask for, on the command line
//! and in a batch file; [`BakeConfig`] is what that means for a scene, recorded in `run.json`.
//!
//! A new setting is a field here, the line of [`Settings::config`] (`apply.rs`) that applies it, and its use.

mod apply;
mod method;
pub mod parse;
mod scene;
mod table;

pub use method::Method;
pub use parse::Hidden;
pub use scene::{SceneOptions, SkyArgs};

use clap::{Args, ValueEnum};
use parse::{input, region, share};
use rrf_extract::{ExtractConfig, ExtractError, NarrowLight, Region, Weights};
use rrf_scene::{LightUnits, LoadOptions, Scene, SkyOption};
use rrf_train::{LmConfig, Precision, TrainConfig};
use serde::{Deserialize, Serialize};

/// Options of a bake.
#[derive(Args, Clone, Debug)]
pub struct Settings {
    /// Box that movable lights will be in. A transfer knows lights anywhere in free space, and with the box most of what
    /// it learns is about points in it. Nets know no others; their default is the middle 80 % of the scene's bounds.
    #[arg(long, value_name = "x0,y0,z0,x1,y1,z1", value_parser = region, allow_hyphen_values = true)]
    pub light_box: Option<Region>,
    /// Box that eyes may be in. Surfaces that cannot be seen from 64 places in it get no rows and
    /// count in no error. By default all surfaces count.
    #[arg(long, value_name = "x0,y0,z0,x1,y1,z1", value_parser = region, allow_hyphen_values = true)]
    pub eye_box: Option<Region>,
    /// Relative error to reach, as 0.05 or 5%.
    #[arg(long, default_value_t = 0.05, value_parser = share)]
    pub target: f32,
    /// Seed of all random numbers.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Amount of work.
    #[arg(long, value_enum, default_value_t = Preset::Standard)]
    pub preset: Preset,
    /// Method that the scene is baked by: a transfer, nets, or a baseline to compare them with.
    #[arg(long, value_enum, default_value_t = Method::default())]
    pub method: Method,
    /// Units of the nets' hidden layers, from the inputs on, instead of the method's (nets: 20,10; global-net: 32,16). A
    /// transfer's nets have one hidden layer.
    #[arg(long, value_name = "A[,B]")]
    pub hidden: Option<Hidden>,
    /// Names of the nets' inputs, with --method nets and its baselines. Those that vary in a cell are used. By default these are position,
    /// normal, viewer, light and material, without the normal and material where the position
    /// determines them. Previews, regressions and global-net use all of these, and the direction and
    /// inverse distance to the light.
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', value_parser = input)]
    pub inputs: Option<Vec<String>>,
    /// Rows of all cells together, instead of the preset's number.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000_000))]
    pub rows: Option<u32>,
    /// Paths for each row, instead of the preset's number.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=65_536))]
    pub paths: Option<u32>,
    /// Maximum of cells in the first round, instead of the preset's, with --method nets and its baselines.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=65_536))]
    pub cells: Option<u32>,
    /// Maximum of rounds, instead of the preset's. In a transfer these are rounds of rows within a surface.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub rounds: Option<u32>,
    /// Maximum of cells in all rounds, instead of the preset's, with --method nets and its baselines.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=65_536))]
    pub most_cells: Option<u32>,
    /// Keep the size of the nets when the target is met, instead of making them smaller until it is
    /// only just met, with --method nets.
    #[arg(long = "no-trim", action = clap::ArgAction::SetFalse)]
    pub trim: bool,
    /// How the scene is read.
    #[command(flatten, next_help_heading = "Reading the scene")]
    pub scene: SceneOptions,
}

/// Amount of work.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Preset {
    /// Seconds: to check a scene.
    Preview,
    /// Minutes: as for the figures in the README.
    Standard,
    /// Hours: for the smallest error.
    Fine,
}

/// The settings of all stages, recorded in `run.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BakeConfig {
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
    /// Maximum of rounds.
    pub rounds: u32,
    /// Maximum of cells in all rounds.
    pub most_cells: u32,
    /// Makes nets smaller once the target is met.
    #[serde(default, rename = "trim")]
    pub compress: bool,
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
            sky: None,
            rounds,
            most_cells,
            compress: true,
            extract: ExtractConfig {
                light_box,
                eye_box: None,
                seed,
                candidates: 65_536,
                cells,
                rows,
                fewest_rows: 1_000,
                paths,
                narrow: NarrowLight::Learned,
                weights: Weights::default(),
            },
            train,
        }
    }

    /// Checks the settings against each other and the scene.
    ///
    /// # Errors
    /// [`ExtractError`].
    pub fn validate(&self, scene: &Scene) -> Result<(), ExtractError> {
        let bounds = scene.bounds().ok_or(ExtractError::NoTriangle)?;
        self.extract.validate(&bounds)
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

/// Inputs that small cells do without: nets learn them from the point and the light (docs/science/report.md).
const WAY_TO_LIGHT: [&str; 4] = ["dx", "dy", "dz", "inv_distance"];
