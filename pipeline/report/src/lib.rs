//! Evidence: what a bake costs and what it gives. The program `rrf-report`, which `rrf inspect`,
//! `rrf chart`, `rrf sweep` and `rrf report` start, so that `rrf` itself stays small and quick to
//! build.
//!
//! [`sweep`] bakes a scene with every setting of a grid and measures each run against a
//! path-traced frame; [`chart`] draws what was measured, as SVG, PNG and one page with hover and
//! zoom; `run_page` writes all about one run on one page; `inspect` shows tables. No page needs
//! anything from outside.
//!
//! A chart is described once and drawn by all:
//!
//! ```
//! use rrf_report::chart::{Axis, Line, Panel, Series, chart_svg};
//!
//! let places = [(1.0, 20.0), (10.0, 8.0), (100.0, 5.0)];
//! let panel = Panel {
//!     x: Axis::log("baking so far [s]"),
//!     y: Axis::log("error on test rows [%]"),
//!     series: vec![Series::line(Some("my run"), Some(0), Line::Solid, places)],
//! };
//! let svg = chart_svg(&[panel])?;
//! assert!(svg.starts_with("<svg") && svg.contains("my run"));
//! # Ok::<(), rrf_report::ReportError>(())
//! ```

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

// first: its macros stand in for the standard library's in all that follows
#[macro_use]
mod print;

pub mod chart;
mod chart_files;
mod error;
mod html;
#[cfg(feature = "inspect")]
mod inspect;
mod program;
mod rounds;
mod run_page;
pub mod sweep;

pub use error::ReportError;
pub use program::{Call, Finished, Program};

use clap::{Parser, Subcommand};
use std::path::PathBuf;
use std::process::ExitCode;

/// Looks at runs and sweeps: tables, charts, pages.
#[derive(Debug, Parser)]
#[command(name = "rrf", version, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    /// The program that bakes and renders; by default the one beside this.
    #[arg(long, global = true, value_name = "PROGRAM")]
    rrf: Option<PathBuf>,
    /// Worker threads of the runs.
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    threads: Option<u32>,
    /// No progress.
    #[arg(long, short, global = true)]
    quiet: bool,
}

#[derive(Debug, Subcommand)]
enum Command {
    #[cfg(feature = "inspect")]
    Inspect(inspect::InspectArgs),
    Chart(chart_files::ChartArgs),
    Sweep(sweep::SweepArgs),
    Report(run_page::ReportArgs),
}

/// Runs the command line. Exit codes: 0 done, 1 failed (could succeed if tried again), 2 bad
/// input or usage.
pub fn main() -> ExitCode {
    #[cfg(unix)]
    // SAFETY: sets a signal's disposition to the default before any thread or handler exists.
    unsafe {
        libc::signal(libc::SIGPIPE, libc::SIG_DFL);
    }
    match run(&Cli::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("rrf: {error}");
            ExitCode::from(if error.is_bad_input() { 2 } else { 1 })
        }
    }
}

fn run(cli: &Cli) -> Result<(), ReportError> {
    match &cli.command {
        #[cfg(feature = "inspect")]
        Command::Inspect(args) => inspect::run(args),
        Command::Chart(args) => chart_files::run(args),
        Command::Sweep(args) => sweep::run(args, &program(cli)?, cli.quiet),
        Command::Report(args) => run_page::run(args, &program(cli)?),
    }
}

/// `rrf` beside this program, unless it was named.
fn program(cli: &Cli) -> Result<Program, ReportError> {
    let threads = cli.threads;
    if let Some(path) = cli.rrf.clone() {
        return Ok(Program { path, threads });
    }
    let this = std::env::current_exe().unwrap_or_default();
    let path = this.with_file_name("rrf");
    if !path.exists() {
        let told = "the program rrf is not there; name it by --rrf";
        return Err(ReportError::input(&path, told));
    }
    Ok(Program { path, threads })
}
