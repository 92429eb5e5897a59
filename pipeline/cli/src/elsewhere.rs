//! `rrf inspect`, `chart`, `sweep` and `report`: the program `rrf-report` beside this one.

use crate::args::{Cli, Elsewhere};
use crate::failure::BadInput;
use anyhow::Context;
use std::process::{Command, ExitCode};

/// Hands everything typed over, options before the command's name too; the exit code is the other program's.
pub fn run(name: &str, args: &Elsewhere, cli: &Cli) -> anyhow::Result<ExitCode> {
    let this = std::env::current_exe().context("this program's own path is not known")?;
    let program = this.with_file_name("rrf-report");
    if !program.exists() {
        return Err(BadInput(format!(
            "{}: rrf {name} needs it; `cargo build --release -p rrf-report` builds it",
            program.display()
        ))
        .into());
    }
    let threads = cli.threads.map(|threads| format!("--threads={threads}"));
    let status = Command::new(&program)
        .args(threads)
        .args(cli.quiet.then_some("--quiet"))
        .arg(name)
        .args(&args.words)
        .status()
        .with_context(|| format!("{}: cannot be started", program.display()))?;
    // ended by a signal: as good as failed
    let code = status.code().and_then(|code| u8::try_from(code).ok());
    Ok(ExitCode::from(code.unwrap_or(1)))
}
