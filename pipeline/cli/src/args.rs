//! What can be typed: every subcommand and option, as plain structs.

use clap::{Args, Parser, Subcommand, ValueEnum};
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

/// Every subcommand. Add one: a variant here, its arguments below, its module beside this file.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Load, plan, extract, train, judge: from a scene file to a run folder.
    Bake(BakeArgs),
    /// The first stages of a bake alone: load, plan, extract.
    Extract(ExtractArgs),
    /// The last stages of a bake alone: train, judge.
    Train(TrainArgs),
    /// Bake everything that a file lists; again: only what changed.
    Run(RunArgs),
    /// Tasks of a bake's next round as a table, for schedulers.
    Plan(PlanArgs),
    /// Do one task of a plan; done ones are skipped.
    Task(TaskArgs),
    /// Check that a round's tasks are done, make their fits the model, plan the next round.
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
    /// Pareto fronts of error against time and size, of sweeps.
    Chart(Elsewhere),
    /// Bake every setting of a grid and measure each run.
    Sweep(Elsewhere),
    /// All about one run on one HTML page.
    Report(Elsewhere),
    /// Print what was understood of a scene file.
    Scene(SceneArgs),
    /// Look through a baked scene in a browser: move, drag lights, compare with the truth.
    View(PageArgs),
    /// Check what this machine offers and whether the program works on it.
    Doctor(DoctorArgs),
}

/// How a scene file is read.
#[derive(Args, Clone, Debug)]
pub struct SceneOptions {
    /// Reflectance of surfaces without a material.
    #[arg(long, value_name = "A", default_value_t = 0.7, value_parser = unit_interval)]
    pub default_albedo: f32,
    /// Unit of glTF light intensities: the Blender exporter's three modes.
    #[arg(long, value_enum, default_value_t = LightUnits::Spec)]
    pub light_units: LightUnits,
}

/// Unit of glTF light intensities.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum LightUnits {
    /// Candela, as the specification says.
    Spec,
    /// Radiometric, W/sr.
    Compat,
    /// Blender's own watts.
    Raw,
}

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

/// What a bake may take; what it makes does not depend on it, but for how many rounds.
#[derive(Args, Clone, Debug, Default)]
pub struct Bounds {
    /// Begin no more work after this many seconds; the model of the last whole round stands.
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

/// A view; what is not given comes from the scene's first camera.
#[derive(Args, Clone, Debug)]
pub struct ViewArgs {
    /// Eye position.
    #[arg(long, value_name = "x,y,z", value_parser = parse_vec3, allow_hyphen_values = true)]
    pub eye: Option<[f32; 3]>,
    /// Where the camera looks.
    #[arg(long, value_name = "x,y,z", value_parser = parse_vec3, allow_hyphen_values = true, requires = "eye")]
    pub look_at: Option<[f32; 3]>,
    /// Up direction.
    #[arg(long, value_name = "x,y,z", value_parser = parse_vec3, allow_hyphen_values = true)]
    pub up: Option<[f32; 3]>,
    /// Turn image left and right around, as left-handed scenes' own cameras do.
    #[arg(long, requires = "eye")]
    pub mirror: bool,
    /// Full angle of the shorter image side [degrees].
    #[arg(long, value_name = "DEG", value_parser = positive)]
    pub fov: Option<f32>,
    /// Picture size in pixels.
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<[u32; 2]>,
    /// A point light: position and radiant intensity [W/sr] (again for more).
    #[arg(long, value_name = "x,y,z[,r,g,b]", value_parser = parse_light, allow_hyphen_values = true)]
    pub light: Vec<[f32; 6]>,
    /// The scene's own lights shine beside those of --light.
    #[arg(long)]
    pub scene_lights: bool,
    /// Which part of the light the picture shows.
    #[arg(long, value_enum, default_value_t = Part::Full)]
    pub part: Part,
    /// Camera rays a pixel are N x N.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=64))]
    pub aa: u32,
    /// Exposure of the PNG in stops; by default chosen from the picture and printed.
    #[arg(long, value_name = "STOPS", allow_hyphen_values = true)]
    pub exposure: Option<f32>,
}

/// Which part of the light a picture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Part {
    /// Direct and indirect.
    Full,
    /// Emission and light that arrives from the lights themselves.
    Direct,
    /// Light that arrives from other surfaces.
    Indirect,
}

/// What becomes of pixels that the nets were not trained for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Fallback {
    /// The nets are believed.
    None,
    /// They are path-traced.
    Trace,
}

/// `rrf render`.
#[derive(Args, Clone, Debug)]
pub struct RenderArgs {
    /// The run folder, baked.
    pub run: PathBuf,
    /// Picture to write (.exr with layers, .png tone-mapped); again for more. With --path the
    /// new folder for frames.
    #[arg(short, long, value_name = "F", required = true)]
    pub output: Vec<PathBuf>,
    /// A frame for each row of a table with the columns eye_x eye_y eye_z target_x target_y
    /// target_z fov, optionally up_x up_y up_z and light0_x light0_y light0_z [light0_r light0_g
    /// light0_b], light1_x ...
    #[arg(long, value_name = "CAMERA.csv", conflicts_with_all = ["eye", "look_at", "up", "fov", "frames", "mirror"])]
    pub path: Option<PathBuf>,
    /// Formats of the frames of --path.
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = [FrameFormat::Exr, FrameFormat::Png])]
    pub formats: Vec<FrameFormat>,
    /// View and lights.
    #[command(flatten)]
    pub view: ViewArgs,
    /// Shadow rays of each camera ray, shared by all lights. By default point lights get one
    /// each, and area lights 16 together.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=65_536))]
    pub shadow_rays: Option<u32>,
    /// How shadow rays choose among lights.
    #[arg(long, value_enum, default_value_t = LightSampling::Adaptive)]
    pub light_sampling: LightSampling,
    /// Render also what is refused otherwise: an eye or a light inside a solid, a light on a
    /// surface.
    #[arg(long)]
    pub anyway: bool,
    /// Seed of the shadow rays.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// What becomes of pixels that the nets were not trained for.
    #[arg(long, value_enum, default_value_t = Fallback::None, conflicts_with_all = ["json_stats", "path"])]
    pub fallback: Fallback,
    /// Paths a pixel and light of --fallback trace.
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(2..))]
    pub fallback_spp: u32,
    /// Paint pixels that the nets were not trained for red, by the share of their samples.
    #[arg(long, conflicts_with_all = ["json_stats", "path"])]
    pub show_trust: bool,
    /// Write what the frame cost, stage by stage, as JSON (`-`: to standard output). Frames are
    /// then made without the layer of trust.
    #[arg(long, value_name = "FILE")]
    pub json_stats: Option<PathBuf>,
    /// Render the frame N times, for --json-stats in steady state.
    #[arg(long, value_name = "N", default_value_t = 1, requires = "json_stats", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub frames: u32,
}

/// How shadow rays choose among lights; both are unbiased.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LightSampling {
    /// By what earlier rays of the pixel and its neighbours found (Donikian et al. 2006).
    Adaptive,
    /// All alike.
    Uniform,
}

/// A format of frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FrameFormat {
    /// OpenEXR, linear, with every layer.
    Exr,
    /// 8-bit sRGB, tone-mapped.
    Png,
}

/// `rrf view`.
#[derive(Args, Clone, Debug)]
pub struct PageArgs {
    /// The run folder, baked.
    pub run: PathBuf,
    /// Port on 127.0.0.1; 0 for a free one.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub port: u16,
    /// Open the page in the desktop's browser; otherwise its URL is printed, and that is all.
    #[arg(long)]
    pub open: bool,
    /// Where the page starts.
    #[command(flatten)]
    pub view: ViewArgs,
}

/// `rrf trace`.
#[derive(Args, Clone, Debug)]
pub struct TraceArgs {
    /// Scene file.
    pub scene: PathBuf,
    /// Picture (.exr, .png; again for more), or with --points the table to write.
    #[arg(short, long, value_name = "F", required = true)]
    pub output: Vec<PathBuf>,
    /// Paths a pixel or a point.
    #[arg(long, value_name = "N", default_value_t = 256)]
    pub spp: u32,
    /// Points table: indirect radiance at its rows instead of a picture.
    #[arg(long, value_name = "IN.parquet", conflicts_with_all = ["eye", "look_at", "light", "part", "fov", "size"])]
    pub points: Option<PathBuf>,
    /// How paths to the point light are made, with --points.
    #[arg(long, value_enum, default_value_t = Estimator::NextEvent, requires = "points")]
    pub estimator: Estimator,
    /// Seed of every random number.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// View and lights.
    #[command(flatten)]
    pub view: ViewArgs,
    /// Reading the scene.
    #[command(flatten)]
    pub scene_options: SceneOptions,
}

/// How paths to a point light are made; both are unbiased.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Estimator {
    /// Next-event estimation alone: the textbook estimator, the same as other path tracers'.
    NextEvent,
    /// Connections to the light's first hits too: less noise, above all for lights near
    /// surfaces. What extraction uses.
    Connected,
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
    /// Eye position; by default the scene's first camera.
    #[arg(long, value_name = "x,y,z", value_parser = parse_vec3, allow_hyphen_values = true)]
    pub eye: Option<[f32; 3]>,
    /// Where the camera looks.
    #[arg(long, value_name = "x,y,z", value_parser = parse_vec3, allow_hyphen_values = true, requires = "eye")]
    pub look_at: Option<[f32; 3]>,
    /// Up direction.
    #[arg(long, value_name = "x,y,z", value_parser = parse_vec3, allow_hyphen_values = true)]
    pub up: Option<[f32; 3]>,
    /// Full angle of the shorter image side [degrees].
    #[arg(long, value_name = "DEG", value_parser = positive)]
    pub fov: Option<f32>,
    /// Picture size in pixels.
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<[u32; 2]>,
    /// A point light instead of the scene's own: position and radiant intensity [W/sr] (again for more).
    #[arg(long, value_name = "x,y,z[,r,g,b]", value_parser = parse_light, allow_hyphen_values = true)]
    pub light: Vec<[f32; 6]>,
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

fn numbers<const N: usize>(text: &str) -> Result<[f32; N], String> {
    let given: Vec<&str> = text.split(',').collect();
    if given.len() != N {
        return Err(format!(
            "needs {N} numbers with commas between, has {}",
            given.len()
        ));
    }
    let mut out = [0.0; N];
    for (out, text) in out.iter_mut().zip(given) {
        *out = number(text)?;
    }
    Ok(out)
}

fn number(text: &str) -> Result<f32, String> {
    let x: f32 = text
        .trim()
        .parse()
        .map_err(|_| format!("{text:?} is no number"))?;
    if x.is_finite() {
        Ok(x)
    } else {
        Err(format!("{text:?} is not finite"))
    }
}

fn parse_vec3(text: &str) -> Result<[f32; 3], String> {
    numbers::<3>(text)
}

fn parse_box(text: &str) -> Result<[f32; 6], String> {
    let b = numbers::<6>(text)?;
    if (0..3).any(|i| b[i] > b[i + 3]) {
        return Err("the first corner has to be the smaller one on every axis".into());
    }
    Ok(b)
}

fn parse_light(text: &str) -> Result<[f32; 6], String> {
    if text.split(',').count() == 3 {
        let p = numbers::<3>(text)?;
        return Ok([p[0], p[1], p[2], 1.0, 1.0, 1.0]);
    }
    let l = numbers::<6>(text).map_err(|e| format!("{e} (or 3 for a light of 1 W/sr)"))?;
    if l[3..].iter().any(|&x| x < 0.0) {
        return Err("an intensity cannot be negative".into());
    }
    Ok(l)
}

fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let parsed = text
        .split_once('x')
        .and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    match parsed {
        Some([w, h]) if (1..=16384).contains(&w) && (1..=16384).contains(&h) => Ok([w, h]),
        _ => Err("needs WIDTHxHEIGHT, each from 1 to 16384, for example 640x480".into()),
    }
}

fn positive(text: &str) -> Result<f32, String> {
    let x = number(text)?;
    if x > 0.0 {
        Ok(x)
    } else {
        Err("has to be above 0".into())
    }
}

fn unit_interval(text: &str) -> Result<f32, String> {
    let x = number(text)?;
    if (0.0..=1.0).contains(&x) {
        Ok(x)
    } else {
        Err("has to be from 0 to 1".into())
    }
}

/// `1500000`, `512MiB`, `2GB`.
fn parse_bytes(text: &str) -> Result<u64, String> {
    let digits = text.find(|c: char| !c.is_ascii_digit() && c != '.');
    let (number, unit) = text.split_at(digits.unwrap_or(text.len()));
    let number: f64 = number.parse().map_err(|_| format!("{text}: no size"))?;
    let scale: f64 = match unit.trim() {
        "" | "B" => 1.0,
        "kB" => 1e3,
        "MB" => 1e6,
        "GB" => 1e9,
        "KiB" => 1024.0,
        "MiB" => 1048576.0,
        "GiB" => 1073741824.0,
        _ => return Err(format!("{unit}: units are B, kB, MB, GB, KiB, MiB, GiB")),
    };
    let bytes = number * scale;
    if (1.0..1e18).contains(&bytes) {
        Ok(bytes as u64)
    } else {
        Err(format!("{text}: not a size of memory"))
    }
}
