//! The command line: what was typed is parsed once, handed to the stages, and their results
//! are printed. One module a subcommand.

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

mod animate;
mod args;
mod bake;
mod baked;
mod batch;
mod compare;
mod doctor;
mod elsewhere;
mod export;
mod failure;
mod page;
mod pictures;
mod place;
mod points;
mod progress;
mod query;
mod render;
mod scene;
mod stats;
mod tasks;
mod trace;
mod trust;
mod view;

use args::{Cli, Command};
use clap::Parser;
use std::process::ExitCode;

/// Runs the command line and returns its exit code.
pub fn main() -> ExitCode {
    end_quietly_on_closed_pipe();
    let cli = Cli::parse();
    match run(&cli) {
        Ok(code) => code,
        Err(error) => {
            eprintln!("rrf: {}", failure::message(&error));
            ExitCode::from(failure::exit_code(&error))
        }
    }
}

fn run(cli: &Cli) -> anyhow::Result<ExitCode> {
    if let Some(threads) = cli.threads {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads as usize)
            .build_global()?;
    }
    match &cli.command {
        Command::Bake(args) => bake::bake(args, cli.quiet),
        Command::Extract(args) => bake::extract(args, cli.quiet),
        Command::Train(args) => bake::train(args, cli.quiet),
        Command::Run(args) => batch::run(args, cli.quiet),
        Command::Plan(args) => tasks::plan(args),
        Command::Task(args) => tasks::task(args),
        Command::Commit(args) => tasks::commit(args),
        Command::Render(args) => render::run(args),
        Command::Export(args) => export::run(args),
        Command::Compare(args) => compare::run(args),
        Command::Trace(args) => trace::run(args, cli.quiet),
        Command::Query(args) => query::run(args),
        Command::Scene(args) => scene::run(args),
        Command::View(args) => page::run(args),
        Command::Doctor(_) => doctor::run(),
        Command::Inspect(args) => return elsewhere::run("inspect", args, cli),
        Command::Chart(args) => return elsewhere::run("chart", args, cli),
        Command::Sweep(args) => return elsewhere::run("sweep", args, cli),
        Command::Report(args) => return elsewhere::run("report", args, cli),
    }?;
    Ok(ExitCode::SUCCESS)
}

/// `rrf compare ... | head` is no failure: like other Unix programs, stop when the reader has.
fn end_quietly_on_closed_pipe() {
    #[cfg(unix)]
    // SAFETY: sets a signal's disposition to the default before any thread or handler exists.
    unsafe {
        libc::signal(libc::SIGPIPE, libc::SIG_DFL);
    }
}
