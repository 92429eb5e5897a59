//! `rrf inspect`, `chart`, `sweep` and `report`: the program `rrf-report` beside this one.

use crate::args::Globals;
use crate::failure::BadInput;
use anyhow::Context;
use clap::Args;
use std::ffi::OsString;
use std::process::Command;

/// Arguments for the program `rrf-report`.
#[derive(Args, Clone, Debug)]
#[command(disable_help_flag = true)]
pub struct ExternalArgs {
    /// See `rrf COMMAND --help`.
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    pub arguments: Vec<OsString>,
}

/// Hands everything typed over, options before the command's name too; the exit code is the other
/// program's.
pub fn run(name: &str, args: &ExternalArgs, globals: &Globals) -> anyhow::Result<u8> {
    let this = std::env::current_exe().context("this program's own path is not known")?;
    let program = this.with_file_name("rrf-report");
    if !program.exists() {
        return Err(BadInput(format!(
            "{}: rrf {name} needs this program, which is not there; build it by `make report`",
            program.display()
        ))
        .into());
    }
    let threads = globals
        .threads
        .map(|threads| format!("--threads={threads}"));
    let status = Command::new(&program)
        .args(threads)
        .args(globals.quiet.then_some("--quiet"))
        .arg(name)
        .args(&args.arguments)
        .status()
        .with_context(|| format!("{}: cannot be started", program.display()))?;
    // ended by a signal: as good as failed
    let code = status.code().and_then(|code| u8::try_from(code).ok());
    Ok(code.unwrap_or(1))
}
