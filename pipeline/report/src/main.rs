//! `rrf-report`: looks at runs and sweeps. `rrf inspect`, `rrf chart`, `rrf sweep` and
//! `rrf report` start it, so that `rrf` itself stays small and quick to build.

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

mod args;
#[cfg(feature = "inspect")]
mod inspect;

use args::{Cli, Command};
use clap::Parser;
use rrf_chart::results::{self, Row};
use rrf_chart::{ChartError, Program, grid::Grid, page, sweep};
use rrf_store::manifest::RunManifest;
use std::path::PathBuf;
use std::process::ExitCode;

/// Bad input found here.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub(crate) struct BadInput(pub(crate) String);

fn main() -> ExitCode {
    #[cfg(unix)]
    // SAFETY: sets a signal's disposition to the default before any thread or handler exists.
    unsafe {
        libc::signal(libc::SIGPIPE, libc::SIG_DFL);
    }
    let cli = Cli::parse();
    match run(&cli) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("rrf: {error:#}");
            ExitCode::from(exit_code(&error))
        }
    }
}

/// 0 done, 1 failed (could succeed if tried again), 2 bad input or usage.
fn exit_code(error: &anyhow::Error) -> u8 {
    let bad = error.chain().any(|cause| {
        cause.is::<BadInput>()
            || cause
                .downcast_ref::<ChartError>()
                .is_some_and(ChartError::is_bad_input)
    });
    if bad { 2 } else { 1 }
}

fn run(cli: &Cli) -> anyhow::Result<()> {
    let program = || -> anyhow::Result<Program> {
        Ok(Program {
            path: rrf(cli)?,
            threads: cli.threads,
        })
    };
    match &cli.command {
        #[cfg(feature = "inspect")]
        Command::Inspect(args) => inspect::run(args),
        Command::Chart(args) => chart(args),
        Command::Sweep(args) => run_sweep(args, program()?, cli.quiet),
        Command::Report(args) => {
            page::write(&page::Page {
                program: program()?,
                run: &args.run,
                view: args.view(),
                spp: args.spp,
                output: &args.output,
            })?;
            println!("{}", args.output.display());
            Ok(())
        }
    }
}

/// `rrf` beside this program, unless it was named.
fn rrf(cli: &Cli) -> anyhow::Result<PathBuf> {
    if let Some(path) = &cli.rrf {
        return Ok(path.clone());
    }
    let beside = std::env::current_exe()?.with_file_name("rrf");
    if beside.exists() {
        return Ok(beside);
    }
    Err(BadInput(format!(
        "{}: not there; name the program with --rrf",
        beside.display()
    ))
    .into())
}

fn run_sweep(args: &args::SweepArgs, program: Program, quiet: bool) -> anyhow::Result<()> {
    let grid = Grid::read(&args.grid)?;
    let rows = sweep::run(
        &sweep::Sweep {
            program,
            scene: &args.scene,
            grid: &grid,
            folder: &args.output,
        },
        &|name, place, total| {
            if !quiet {
                eprintln!("{place} of {total}: {name}");
            }
        },
    )?;
    let table = args.output.join("results.parquet");
    println!("{} runs: {}", rows.len(), table.display());
    Ok(())
}

fn chart(args: &args::ChartArgs) -> anyhow::Result<()> {
    let is_run = |path: &PathBuf| RunManifest::path(path).exists();
    let (runs, sweeps): (Vec<_>, Vec<_>) = args.sources.iter().cloned().partition(is_run);
    let mut written = Vec::new();
    if !runs.is_empty() {
        written.extend(rrf_chart::rounds::write(&args.output, &runs)?);
    }
    if let Some(first) = sweeps.first() {
        let rows = sweep_rows(&sweeps)?;
        written.extend(rrf_chart::chart::write(&args.output, first, &rows)?);
    }
    for path in written {
        println!("{}", path.display());
    }
    Ok(())
}

/// The rows of all sweeps.
fn sweep_rows(sweeps: &[PathBuf]) -> anyhow::Result<Vec<Row>> {
    let mut rows = Vec::new();
    for source in sweeps {
        let table = if source.is_dir() {
            source.join("results.parquet")
        } else {
            source.clone()
        };
        if !table.exists() {
            return Err(BadInput(format!(
                "{}: neither a run (run.json) nor a sweep (results.parquet)",
                source.display()
            ))
            .into());
        }
        rows.extend(results::read(&table)?);
    }
    Ok(rows)
}
