//! What can be typed: every subcommand and option, as plain structs.

mod bake;
mod parse;
mod view;

pub use bake::*;
pub use view::*;

use clap::{Args, Parser, Subcommand};
use rrf_bake::settings::SceneOptions;
use std::path::PathBuf;

/// Bakes a static scene's indirect light into small neural nets; viewpoint and lights stay free.
#[derive(Debug, Parser)]
#[command(name = "rrf", version, max_term_width = 100)]
pub struct Cli {
    /// The subcommand.
    #[command(subcommand)]
    pub command: Command,
    /// Worker threads (results do not depend on it).
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub threads: Option<u32>,
    /// No progress bars.
    #[arg(long, short, global = true)]
    pub quiet: bool,
}

/// Every subcommand. Add one: a variant here, its arguments beside this file, its module and two lines in `cli/src/lib.rs`.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Bake a scene file into a run folder: load, plan, extract, train, evaluate.
    Bake(BakeArgs),
    /// The first stages of a bake alone: load, plan, extract.
    Extract(ExtractArgs),
    /// The last stages of a bake alone: train, evaluate.
    Train(TrainArgs),
    /// Bake everything that a file lists, or what has changed since.
    Run(RunArgs),
    /// Write the tasks of a bake's next round as a table, for schedulers.
    Plan(PlanArgs),
    /// Perform one task of a plan, unless it is done.
    Task(TaskArgs),
    /// Commit a round whose tasks are done: its fits become the model, and the next round is planned.
    Commit(CommitArgs),
    /// Render a frame by the baked nets (plus exact direct light).
    Render(RenderArgs),
    /// Render a frame, or points, by path tracing: the ground truth.
    Trace(TraceArgs),
    /// The model's indirect radiance at points of a table.
    Query(QueryArgs),
    /// The scene for Mitsuba 3, or the baked nets as tensors.
    Export(ExportArgs),
    /// Compare two EXR frames: relMSE, relative error, ΔE*ab, ΔE2000, FLIP.
    Compare(CompareArgs),
    /// A dataset, a model, a sweep or a table at a glance.
    Inspect(Elsewhere),
    /// Error against time and size, of sweeps, or round by round, of runs.
    Chart(Elsewhere),
    /// Bake every setting of a grid and measure each run.
    Sweep(Elsewhere),
    /// All about one run on one HTML page.
    Report(Elsewhere),
    /// Print what was understood of a scene file.
    Scene(SceneArgs),
    /// Look through a baked scene in a browser: move, drag lights, compare with the truth.
    View(PageArgs),
    /// What this machine offers: threads, vector instructions, a temporary folder that can be written.
    Doctor(DoctorArgs),
}

/// `rrf query`.
#[derive(Args, Clone, Debug)]
pub struct QueryArgs {
    /// The run folder, baked.
    pub run: PathBuf,
    /// Points table.
    #[arg(long, value_name = "IN.parquet")]
    pub points: PathBuf,
    /// Table to write.
    #[arg(short, long, value_name = "OUT.parquet")]
    pub output: PathBuf,
    /// Blend the nets of neighbouring cells within a tenth of a cell where they meet and agree, so that
    /// their borders do not show.
    #[arg(long)]
    pub blend: bool,
    /// Which cells are believed.
    #[command(flatten)]
    pub trust: TrustArgs,
}
/// `rrf export`.
#[derive(Args, Clone, Debug)]
#[command(group = clap::ArgGroup::new("format").required(true).multiple(true))]
pub struct ExportArgs {
    /// A run folder, or for --mitsuba a scene file.
    pub input: PathBuf,
    /// Folder for scene.xml, meshes and textures that Mitsuba 3 loads.
    #[arg(long, value_name = "DIR", group = "format")]
    pub mitsuba: Option<PathBuf>,
    /// File for the nets and their kd-tree.
    #[arg(long, value_name = "F", group = "format")]
    pub safetensors: Option<PathBuf>,
    /// File for the same as one ONNX graph.
    #[arg(long, value_name = "F", group = "format")]
    pub onnx: Option<PathBuf>,
    /// Camera and lights that go into --mitsuba's scene.
    #[command(flatten)]
    pub camera: CameraArgs,
    /// Reading the scene.
    #[command(flatten)]
    pub scene_options: SceneOptions,
}
/// `rrf compare`.
#[derive(Args, Clone, Debug)]
pub struct CompareArgs {
    /// The frame to judge.
    pub a: PathBuf,
    /// The reference.
    pub b: PathBuf,
    /// Layer to compare (full, direct, indirect).
    #[arg(long, default_value = "full")]
    pub layer: String,
    /// Exposure in stops for the colour differences; by default chosen from the reference.
    #[arg(long, value_name = "STOPS", allow_hyphen_values = true)]
    pub exposure: Option<f32>,
    /// Machine-readable output.
    #[arg(long)]
    pub json: bool,
}

/// Words for the program `rrf-report`.
#[derive(Args, Clone, Debug)]
#[command(disable_help_flag = true)]
pub struct Elsewhere {
    /// See `rrf COMMAND --help`.
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    pub words: Vec<std::ffi::OsString>,
}

/// `rrf scene`.
#[derive(Args, Clone, Debug)]
pub struct SceneArgs {
    /// Scene file.
    pub scene: PathBuf,
    /// Machine-readable output.
    #[arg(long)]
    pub json: bool,
    /// Reading the scene.
    #[command(flatten)]
    pub scene_options: SceneOptions,
}

/// `rrf doctor`.
#[derive(Args, Clone, Debug)]
pub struct DoctorArgs {}
