//! Arguments of bakes, whole, in stages and as tasks.

use super::parse::parse_bytes;
use clap::{Args, ValueEnum};
use rrf_bake::Settings;
use rrf_bake::settings::parse::positive;
use std::path::PathBuf;

/// `rrf bake`.
#[derive(Args, Clone, Debug)]
pub struct BakeArgs {
    /// Scene file (.pbrt, .gltf, .glb, .obj).
    pub scene: PathBuf,
    /// The run folder to make.
    #[arg(short, long, value_name = "RUN")]
    pub output: PathBuf,
    /// Continue an interrupted run; finished work is kept.
    #[arg(long)]
    pub resume: bool,
    /// Print the result as JSON.
    #[arg(long)]
    pub json: bool,
    /// End with exit code 3 if the target is missed.
    #[arg(long)]
    pub require_target: bool,
    /// Limits of time and memory.
    #[command(flatten, next_help_heading = "Limits")]
    pub bounds: Bounds,
    /// Settings.
    #[command(flatten, next_help_heading = "Settings")]
    pub settings: Settings,
}

/// Limits of time and memory. Results do not depend on them, except for the number of rounds and the
/// work of the last one.
#[derive(Args, Clone, Debug, Default)]
pub struct Bounds {
    /// Stop after this many seconds. A transfer that is not done by then keeps the surfaces that are, for --resume; it
    /// gives cells that err further rows only as far as there is time. Nets have the model of the last complete
    /// round, and the last round only starts work that it expects to finish in time.
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    pub time_limit: Option<f32>,
    /// Memory limit: of nets for all tasks that run at the same time; of a transfer for the rows of a surface and the fits.
    #[arg(long, value_name = "BYTES|2GiB", value_parser = parse_bytes)]
    pub memory: Option<u64>,
}

/// `rrf extract`.
#[derive(Args, Clone, Debug)]
pub struct ExtractArgs {
    /// The bake's arguments.
    #[command(flatten)]
    pub bake: BakeArgs,
    /// Extract only this cell; may be given several times.
    #[arg(long, value_name = "ID")]
    pub cell: Vec<u32>,
}

/// `rrf train`.
#[derive(Args, Clone, Debug)]
pub struct TrainArgs {
    /// The run folder, with samples.
    pub run: PathBuf,
    /// Rows that a step of the trainer sees.
    #[arg(long, value_enum, default_value_t = TrainMode::Local)]
    pub mode: TrainMode,
    /// Rows of a batch, with `--mode online` and `--mode recursive`.
    #[arg(long, value_name = "N", default_value_t = 512, value_parser = clap::value_parser!(u32).range(1..))]
    pub batch: u32,
    /// Limits of time and memory.
    #[command(flatten)]
    pub bounds: Bounds,
}

/// Rows that a step of the trainer sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum TrainMode {
    /// All rows of the cell.
    Local,
    /// Batch after batch, each on its own: forgets earlier ones, for comparison.
    Online,
    /// Batch after batch, remembering the earlier ones.
    Recursive,
}

/// `rrf run`.
#[derive(Args, Clone, Debug)]
pub struct RunArgs {
    /// List of bakes, TOML (see docs/guide/batch.md).
    pub batch: PathBuf,
    /// Check everything and print the predicted cost; write nothing.
    #[arg(long)]
    pub dry_run: bool,
    /// Bake the others where a scene or setting is wrong; the exit code is then 2.
    #[arg(long)]
    pub keep_going: bool,
    /// End with exit code 3 if a target is missed.
    #[arg(long)]
    pub require_target: bool,
    /// Print a line of JSON for each round, and the summary at the end.
    #[arg(long)]
    pub json: bool,
    /// Limits of time and memory for all bakes together.
    #[command(flatten, next_help_heading = "Limits")]
    pub bounds: Bounds,
}

/// `rrf plan`.
#[derive(Args, Clone, Debug)]
pub struct PlanArgs {
    /// A run folder, or with --output a scene file.
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
    /// Continue with a run that exists.
    #[arg(long)]
    pub resume: bool,
    /// Settings of a new run.
    #[command(flatten, next_help_heading = "Settings")]
    pub settings: Settings,
}

/// `rrf task`.
#[derive(Args, Clone, Debug)]
pub struct TaskArgs {
    /// The plan, RUN/rounds/000/tasks.parquet.
    #[arg(long, value_name = "P")]
    pub plan: PathBuf,
    /// Id of the task; by default SLURM_ARRAY_TASK_ID or JOB_COMPLETION_INDEX.
    #[arg(long, value_name = "N")]
    pub index: Option<u32>,
    /// Number added to a scheduler's index, for plans larger than its arrays.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub offset: u32,
    /// Memory limit, such as 500MiB or 2GiB. A fit that needs more keeps its rows in a file.
    #[arg(long, value_name = "BYTES|2GiB", value_parser = parse_bytes)]
    pub memory: Option<u64>,
}

/// `rrf commit`.
#[derive(Args, Clone, Debug)]
pub struct CommitArgs {
    /// The run folder.
    pub run: PathBuf,
    /// Print the result as JSON.
    #[arg(long)]
    pub json: bool,
}
