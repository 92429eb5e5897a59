//! `rrf verify`: whether a run's files are what was written.

use crate::failure::BadInput;
use crate::run_location::RunLocation;
use clap::Args;
use rrf_bake::{RunMethod, Verification};
use std::path::PathBuf;

/// Check every file of a run: hashes, schemas, counts, and whether they belong together.
#[derive(Args, Clone, Debug)]
pub struct VerifyArgs {
    /// The run folder.
    pub run: PathBuf,
    /// Machine-readable output.
    #[arg(long)]
    pub json: bool,
}

/// Prints every damage with its remedy; fails where there is one.
pub fn run(args: &VerifyArgs) -> anyhow::Result<()> {
    let location = RunLocation::existing(&args.run)?;
    let found = rrf_bake::verify(location.folder())?;
    if args.json {
        println!("{}", serde_json::to_string_pretty(&found)?);
    } else {
        // a damaged run.json is one of the damages
        let method = RunMethod::of(location.folder()).ok();
        print(args, &found, method);
    }
    match found.damages.len() {
        0 => Ok(()),
        count => Err(BadInput(format!(
            "{}: {count} damage{}",
            args.run.display(),
            if count == 1 { "" } else { "s" }
        ))
        .into()),
    }
}

fn print(args: &VerifyArgs, found: &Verification, method: Option<RunMethod>) {
    for damage in &found.damages {
        println!(
            "{}: {}. {}",
            damage.path.display(),
            damage.what,
            damage.remedy
        );
    }
    for path in &found.unknown {
        println!(
            "{}: not a file of the run; nothing reads it",
            path.display()
        );
    }
    let state = match found.open_tasks {
        0 => String::new(),
        _ if found.rounds == 0 => ", the bake is not finished".into(),
        open => format!(", {open} tasks of the last round are not done"),
    };
    println!(
        "{}: {} files, {:.1} MB, {}{state}: {}",
        args.run.display(),
        found.files,
        found.bytes as f64 / 1e6,
        match method {
            Some(RunMethod::Transfer) => "a transfer".into(),
            _ => format!("{} rounds", found.rounds),
        },
        if found.damages.is_empty() {
            "whole"
        } else {
            "damaged"
        }
    );
}
