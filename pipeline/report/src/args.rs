//! What can be typed.

use clap::{Args, Parser, Subcommand};
use std::ffi::OsString;
use std::path::PathBuf;

/// Looks at runs and sweeps: tables, charts, pages.
#[derive(Debug, Parser)]
#[command(name = "rrf", version, max_term_width = 100)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
    /// The program that bakes and renders; by default the one beside this.
    #[arg(long, global = true, value_name = "PROGRAM")]
    pub(crate) rrf: Option<PathBuf>,
    /// Worker threads of the runs.
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub(crate) threads: Option<u32>,
    /// No progress.
    #[arg(long, short, global = true)]
    pub(crate) quiet: bool,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// A dataset, a model, a sweep or a table at a glance.
    #[cfg(feature = "inspect")]
    Inspect(InspectArgs),
    /// Error against time and size, of a sweep or round by round of runs: SVG, PNG, HTML.
    Chart(ChartArgs),
    /// Bake every setting of a grid and measure each run; goes on where it was cut off.
    Sweep(SweepArgs),
    /// All about one run on one HTML page.
    Report(ReportArgs),
}

#[cfg(feature = "inspect")]
#[derive(Args, Debug)]
pub(crate) struct InspectArgs {
    /// A run or sweep folder, or a Parquet or Arrow file.
    pub(crate) path: PathBuf,
    /// A query over the tables samples, tree, weights, metrics, results; a single file is `self`.
    #[arg(long, value_name = "QUERY")]
    pub(crate) sql: Option<String>,
    /// Machine-readable output.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args, Debug)]
pub(crate) struct ChartArgs {
    /// Sweep folders or results.parquet files, or run folders.
    #[arg(required = true)]
    pub(crate) sources: Vec<PathBuf>,
    /// Folder for frontier.svg, .png and .html of sweeps, rounds.svg, .png and .html of runs.
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
}

#[derive(Args, Debug)]
pub(crate) struct SweepArgs {
    /// Scene file.
    pub(crate) scene: PathBuf,
    /// The sweep's folder.
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
    /// Which settings: see the crate rrf-chart's `grid`.
    #[arg(long, value_name = "grid.toml")]
    pub(crate) grid: PathBuf,
}

#[derive(Args, Debug)]
pub(crate) struct ReportArgs {
    /// The run folder, baked.
    pub(crate) run: PathBuf,
    /// The page.
    #[arg(short, long, value_name = "F.html")]
    pub(crate) output: PathBuf,
    /// Paths a pixel of the path-traced frame.
    #[arg(long, value_name = "N", default_value_t = 256)]
    pub(crate) spp: u32,
    /// Eye position; by default the scene's first camera.
    #[arg(long, value_name = "x,y,z", allow_hyphen_values = true)]
    pub(crate) eye: Option<String>,
    /// Where the camera looks.
    #[arg(long, value_name = "x,y,z", allow_hyphen_values = true)]
    pub(crate) look_at: Option<String>,
    /// Full angle of the shorter image side [degrees].
    #[arg(long, value_name = "DEG")]
    pub(crate) fov: Option<String>,
    /// Picture size in pixels.
    #[arg(long, value_name = "WxH", default_value = "320x320")]
    pub(crate) size: String,
    /// A point light (again for more); by default one of 1 W/sr in the middle of the light box.
    #[arg(long, value_name = "x,y,z[,r,g,b]", allow_hyphen_values = true)]
    pub(crate) light: Vec<String>,
}

impl ReportArgs {
    /// The options of `rrf render`; that program checks them.
    pub(crate) fn view(&self) -> Vec<OsString> {
        let mut words: Vec<OsString> = vec!["--size".into(), self.size.clone().into()];
        let options = [
            ("--eye", &self.eye),
            ("--look-at", &self.look_at),
            ("--fov", &self.fov),
        ];
        for (name, value) in options {
            if let Some(value) = value {
                words.extend([name.into(), value.into()]);
            }
        }
        for light in &self.light {
            words.extend(["--light".into(), light.into()]);
        }
        words
    }
}
