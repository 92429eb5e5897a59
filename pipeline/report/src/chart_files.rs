//! `rrf chart`: charts of sweeps and of runs.

use crate::ReportError;
use crate::rounds::write_rounds;
use crate::sweep::{read_results, write_frontier};
use rrf_store::manifest::RunManifest;
use std::path::PathBuf;

/// Draw error against time and size of sweeps, or round by round of runs: SVG, PNG, HTML.
#[derive(clap::Args, Debug)]
pub struct ChartArgs {
    /// Sweep folders or results.parquet files, or run folders.
    #[arg(required = true)]
    sources: Vec<PathBuf>,
    /// Folder for frontier.svg, .png and .html of sweeps, rounds.svg, .png and .html of runs.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
}

/// Draws runs and sweeps apart, and says which files were written.
pub(crate) fn run(args: &ChartArgs) -> Result<(), ReportError> {
    let is_run = |path: &PathBuf| RunManifest::path(path).exists();
    let (runs, sweeps): (Vec<_>, Vec<_>) = args.sources.iter().cloned().partition(is_run);
    let mut written = Vec::new();
    if !runs.is_empty() {
        written.extend(write_rounds(&args.output, &runs)?);
    }
    if let Some(first) = sweeps.first() {
        let mut rows = Vec::new();
        for source in &sweeps {
            let table = match source.is_dir() {
                true => source.join("results.parquet"),
                false => source.clone(),
            };
            if !table.exists() {
                let told = "neither a run (run.json) nor a sweep (results.parquet)";
                return Err(ReportError::input(source, told));
            }
            rows.extend(read_results(&table)?);
        }
        written.extend(write_frontier(&args.output, first, &rows)?);
    }
    for path in written {
        println!("{}", path.display());
    }
    Ok(())
}
