//! Arguments of pictures.

use super::SceneOptions;
use super::parse::{parse_light, parse_size, parse_vec3};
use clap::{Args, ValueEnum};
use rrf_bake::settings::parse::positive;
use std::path::PathBuf;

/// A camera and lights; what is not given comes from the scene.
#[derive(Args, Clone, Debug)]
pub struct CameraArgs {
    /// Eye position.
    #[arg(long, value_name = "x,y,z", value_parser = parse_vec3, allow_hyphen_values = true)]
    pub eye: Option<[f32; 3]>,
    /// Where the camera looks.
    #[arg(long, value_name = "x,y,z", value_parser = parse_vec3, allow_hyphen_values = true, requires = "eye")]
    pub look_at: Option<[f32; 3]>,
    /// Up direction.
    #[arg(long, value_name = "x,y,z", value_parser = parse_vec3, allow_hyphen_values = true, requires = "eye")]
    pub up: Option<[f32; 3]>,
    /// Turn image left and right around, as left-handed scenes' own cameras do.
    #[arg(long, requires = "eye")]
    pub mirror: bool,
    /// Full angle of the shorter image side [degrees].
    #[arg(long, value_name = "DEG", value_parser = positive)]
    pub fov: Option<f32>,
    /// Picture size in pixels; by default the scene camera's, with --eye 512x512.
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<[u32; 2]>,
    /// A point light: position and radiant intensity [W/sr] (again for more).
    #[arg(long, value_name = "x,y,z[,r,g,b]", value_parser = parse_light, allow_hyphen_values = true)]
    pub light: Vec<[f32; 6]>,
    /// The scene's own lights shine beside those of --light.
    #[arg(long)]
    pub scene_lights: bool,
}

/// What a picture shows and how it is made.
#[derive(Args, Clone, Debug)]
pub struct ViewArgs {
    /// Camera and lights.
    #[command(flatten)]
    pub camera: CameraArgs,
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

/// Which cells are believed.
#[derive(Args, Clone, Debug)]
pub struct TrustArgs {
    /// Cells whose relative error on rows held out is above this, by more than two standard errors, are not trusted: 0.1 with
    /// --fallback trace leaves to the nets what they know within 10 %.
    #[arg(long, value_name = "ERROR", default_value_t = 0.5, value_parser = positive)]
    pub trust_error: f32,
}

/// What becomes of pixels that are not trusted.
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
    /// each, and area lights 16 together; with `--light-sampling uniform` all lights 16 together.
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
    /// Blend the nets of neighbouring cells within a tenth of a cell where they meet and agree, so that
    /// their borders do not show.
    #[arg(long, conflicts_with = "json_stats")]
    pub blend: bool,
    /// Which cells are believed.
    #[command(flatten)]
    pub trust: TrustArgs,
    /// What becomes of pixels that are not trusted.
    #[arg(long, value_enum, default_value_t = Fallback::None, conflicts_with_all = ["json_stats", "path"])]
    pub fallback: Fallback,
    /// Paths a pixel and light of --fallback trace.
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(2..))]
    pub fallback_spp: u32,
    /// Paint pixels that are not trusted red, by the share of their samples.
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
    /// OpenEXR, linear, with every layer but `trust`.
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
    /// Which cells are believed.
    #[command(flatten)]
    pub trust: TrustArgs,
    /// Where the page starts; without --light by one white light in the middle of the light box.
    #[command(flatten)]
    pub camera: CameraArgs,
}

/// `rrf trace`.
#[derive(Args, Clone, Debug)]
pub struct TraceArgs {
    /// Scene file.
    pub scene: PathBuf,
    /// Picture (.exr, .png; again for more), or with --points the table to write.
    #[arg(short, long, value_name = "F", required = true)]
    pub output: Vec<PathBuf>,
    /// Paths a pixel, or a point: a multiple of 16 there.
    #[arg(long, value_name = "N", default_value_t = 256)]
    pub spp: u32,
    /// Points table: indirect radiance at its rows instead of a picture.
    #[arg(long, value_name = "IN.parquet", conflicts_with_all = ["eye", "look_at", "up", "mirror", "light", "scene_lights", "part", "aa", "exposure", "fov", "size"])]
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
