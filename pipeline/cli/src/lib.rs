//! The command line: what was typed is parsed once, handed to the stages, and their results
//! are printed. A subcommand is one file in `commands`.

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

// first: its macros stand in for the standard library's in all that follows
#[macro_use]
mod print;

mod args;
mod baked;
mod clock;
mod commands;
pub mod embedded;
mod failure;
mod film;
mod forecast;
mod heartbeat;
mod memory;
mod pictures;
mod point_rows;
mod points;
mod progress;
mod reach;
mod relightable;
mod residual;
mod run_location;
mod scene_file;
mod stats;
mod table_lights;
mod trust;

use clap::{CommandFactory, FromArgMatches, Parser};
use std::ffi::OsString;
use std::process::ExitCode;

/// Bakes a static scene's indirect light into small neural nets; viewpoint and lights stay free.
#[derive(Debug, Parser)]
#[command(name = "rrf", version, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    command: commands::Command,
    #[command(flatten)]
    globals: args::Globals,
}

/// Runs the command line and returns its exit code.
pub fn main() -> ExitCode {
    memory::start_within_limits();
    // SAFETY: no thread exists yet but this one and idle ones of the linear algebra library.
    unsafe { rrf_train::fix_kernels() };
    ExitCode::from(run_words(std::env::args_os()))
}

/// Runs the command line `words`, the program's name first; gives its exit code.
fn run_words(words: impl IntoIterator<Item = OsString>) -> u8 {
    end_quietly_on_closed_pipe();
    let parsed = Cli::from_arg_matches(&command().get_matches_from(words));
    let cli = parsed.unwrap_or_else(|error| error.exit());
    match run(&cli) {
        Ok(code) => code,
        Err(error) => {
            eprintln!("rrf: {}", failure::message(&error));
            failure::exit_code(&error)
        }
    }
}

/// The command line, its commands in groups.
fn command() -> clap::Command {
    commands::groups::grouped(Cli::command())
}

fn run(cli: &Cli) -> anyhow::Result<u8> {
    if cli.command.bounds_memory() || memory::address_space().is_some() {
        memory::give_back();
    }
    if let Some(threads) = cli.globals.threads {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads as usize)
            .build_global()?;
    }
    cli.command.run(&cli.globals)
}

/// `rrf compare ... | head` is no failure: like other Unix programs, stop when the reader has.
fn end_quietly_on_closed_pipe() {
    #[cfg(unix)]
    // SAFETY: sets a signal's disposition to the default before any thread or handler exists.
    unsafe {
        libc::signal(libc::SIGPIPE, libc::SIG_DFL);
    }
}
