//! Arguments of bakes, whole, in stages and as tasks.

use super::SceneOptions;
use super::parse::{Hidden, parse_box, parse_bytes, parse_hidden, parse_input, positive};
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// `rrf bake`.
#[derive(Args, Clone, Debug)]
pub struct BakeArgs {
    /// Scene file (.pbrt, .gltf, .glb, .obj).
    pub scene: PathBuf,
    /// The run folder to make.
    #[arg(short, long, value_name = "RUN")]
    pub output: PathBuf,
    /// How long and how large.
    #[command(flatten)]
    pub bounds: Bounds,
    /// Settings.
    #[command(flatten)]
    pub settings: BakeSettings,
}

/// What a bake may take; what it makes does not depend on it, but for how many rounds and how much of
/// the last.
#[derive(Args, Clone, Debug, Default)]
pub struct Bounds {
    /// Begin no more work after this many seconds: the last round takes what should fit, and the model
    /// of the last whole round stands; of a round that only makes nets smaller, what is done.
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    pub time_limit: Option<f32>,
    /// Memory that the work in hand may need: fewer tasks side by side.
    #[arg(long, value_name = "BYTES|2GiB", value_parser = parse_bytes)]
    pub memory: Option<u64>,
}

/// What a bake is asked for.
#[derive(Args, Clone, Debug)]
pub struct BakeSettings {
    /// Where lights may stand; by default the middle 80 % of the scene's bounds.
    #[arg(long, value_name = "x0,y0,z0,x1,y1,z1", value_parser = parse_box, allow_hyphen_values = true)]
    pub light_box: Option<[f32; 6]>,
    /// Where eyes may be: what 64 places in it do not see gets no rows and counts in no error; by default all
    /// surface counts.
    #[arg(long, value_name = "x0,y0,z0,x1,y1,z1", value_parser = parse_box, allow_hyphen_values = true)]
    pub eye_box: Option<[f32; 6]>,
    /// Relative error to reach.
    #[arg(long, default_value_t = 0.05, value_parser = positive)]
    pub target: f32,
    /// Seed of every random number.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// How much work.
    #[arg(long, value_enum, default_value_t = Preset::Standard)]
    pub preset: Preset,
    /// What each cell is fitted by: nets, or a baseline to compare them with.
    #[arg(long, value_enum, default_value_t = Method::Nets)]
    pub method: Method,
    /// Units of the nets' hidden layers, inputs side first, instead of 20,10 (global-net: 32,16).
    #[arg(long, value_name = "A[,B]", value_parser = parse_hidden)]
    pub hidden: Option<Hidden>,
    /// Names of the nets' inputs, all kept that vary and can matter, instead of position, normal, viewer, light
    /// and material, less normal and material where the position tells them (previews, regressions and
    /// global-net: all of these, and direction and inverse distance to the light).
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', value_parser = parse_input)]
    pub inputs: Option<Vec<String>>,
    /// Go on with a run that was cut off; what is done stays.
    #[arg(long)]
    pub resume: bool,
    /// Rows of all cells together, instead of the preset's.
    #[arg(long, value_name = "N")]
    pub rows: Option<u32>,
    /// Paths a row, instead of the preset's.
    #[arg(long, value_name = "N")]
    pub paths: Option<u32>,
    /// Cells of the first round at the most, instead of the preset's.
    #[arg(long, value_name = "N")]
    pub cells: Option<u32>,
    /// Rounds at the most, instead of the preset's.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub rounds: Option<u32>,
    /// Cells of all rounds at the most, instead of the preset's.
    #[arg(long, value_name = "N")]
    pub most_cells: Option<u32>,
    /// Leave nets as large as they are when the target is met, instead of making them smaller until it is
    /// only just met.
    #[arg(long)]
    pub no_trim: bool,
    /// Reading the scene.
    #[command(flatten)]
    pub scene_options: SceneOptions,
}

/// What each cell is fitted by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Method {
    /// Nets with exponential outputs.
    Nets,
    /// Nets whose outputs are radiance itself, as Ren et al. 2013 have them.
    LinearOutputs,
    /// Linear regression on the same inputs.
    LinearRegression,
    /// Quadratic regression on the same inputs.
    QuadraticRegression,
    /// The eight nearest of the rows trained on, weighted by inverse squared distance.
    Nearest,
    /// A grid of irradiance probes for a grid of light positions; Lambertian scenes.
    Probes,
    /// One net for the whole scene.
    GlobalNet,
}

/// How much work a bake does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Preset {
    /// Seconds: to see whether a scene and a light box make sense.
    Preview,
    /// Minutes: what the README's figures are made with.
    Standard,
    /// As long as it takes.
    Fine,
}

/// `rrf extract`.
#[derive(Args, Clone, Debug)]
pub struct ExtractArgs {
    /// The bake's arguments.
    #[command(flatten)]
    pub bake: BakeArgs,
    /// Extract this cell alone (again for more).
    #[arg(long, value_name = "ID")]
    pub cell: Vec<u32>,
}

/// `rrf train`.
#[derive(Args, Clone, Debug)]
pub struct TrainArgs {
    /// The run folder, extracted.
    pub run: PathBuf,
    /// Which rows a step of the trainer sees.
    #[arg(long, value_enum, default_value_t = TrainMode::Local)]
    pub mode: TrainMode,
    /// Rows a batch, with `--mode online` and `--mode recursive`.
    #[arg(long, value_name = "N", default_value_t = 512, value_parser = clap::value_parser!(u32).range(1..))]
    pub batch: u32,
    /// How long and how large.
    #[command(flatten)]
    pub bounds: Bounds,
}

/// Which rows a step of the trainer sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum TrainMode {
    /// All rows of the cell.
    Local,
    /// Batch after batch, each on its own: forgets; to compare with.
    Online,
    /// Batch after batch, keeping what the earlier ones taught.
    Recursive,
}

/// `rrf run`.
#[derive(Args, Clone, Debug)]
pub struct RunArgs {
    /// The list, TOML (see docs/batch.md).
    pub batch: PathBuf,
    /// Check everything and print what it would take; nothing is written.
    #[arg(long)]
    pub dry_run: bool,
    /// How long all of it and how large.
    #[command(flatten)]
    pub bounds: Bounds,
}

/// `rrf plan`.
#[derive(Args, Clone, Debug)]
pub struct PlanArgs {
    /// A run folder; or, with --output, a scene file.
    #[arg(value_name = "RUN|SCENE")]
    pub input: PathBuf,
    /// The run folder to make for a scene.
    #[arg(short, long, value_name = "RUN")]
    pub output: Option<PathBuf>,
    /// Print the ids of the tasks that are not done.
    #[arg(long)]
    pub missing: bool,
    /// Print the tasks as JSON.
    #[arg(long)]
    pub json: bool,
    /// Settings of a new run.
    #[command(flatten)]
    pub settings: BakeSettings,
}

/// `rrf task`.
#[derive(Args, Clone, Debug)]
pub struct TaskArgs {
    /// The plan, RUN/rounds/000/tasks.parquet.
    #[arg(long, value_name = "P")]
    pub plan: PathBuf,
    /// Which task; by default SLURM_ARRAY_TASK_ID or JOB_COMPLETION_INDEX.
    #[arg(long, value_name = "N")]
    pub index: Option<u32>,
    /// Added to the index of a scheduler, for plans larger than its arrays may be.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub offset: u32,
    /// Memory that the task may need, as 500MiB or 2GiB: a fit of more keeps its rows in a file.
    #[arg(long, value_name = "BYTES|2GiB", value_parser = parse_bytes)]
    pub memory: Option<u64>,
}

/// `rrf commit`.
#[derive(Args, Clone, Debug)]
pub struct CommitArgs {
    /// The run folder.
    pub run: PathBuf,
    /// Print what came out as JSON.
    #[arg(long)]
    pub json: bool,
}
