//! `rrf inspect`: tables at a glance, by polars.

mod glance;
mod open;
mod print;
mod tables;

use crate::ReportError;
use std::path::PathBuf;
use tables::{Result, answer};

/// Show what a dataset, a model, a sweep or a table holds.
#[derive(clap::Args, Debug)]
pub struct InspectArgs {
    /// A run or sweep folder, or a Parquet or Arrow file.
    path: PathBuf,
    /// A query over the tables samples, tree, weights and metrics, of a transfer transfer, transfer_tree, transfer_cells
    /// and transfer_parts, of a sweep results; a single file is `self`.
    #[arg(long, value_name = "QUERY")]
    sql: Option<String>,
    /// Machine-readable output.
    #[arg(long)]
    json: bool,
}

/// Answers the query, or shows every table. Files are not trusted: a decoder that gives up on
/// one by a panic makes it bad input like any other.
pub(crate) fn run(args: &InspectArgs) -> Result<()> {
    let report = std::panic::take_hook();
    std::panic::set_hook(Box::new(|_| {}));
    let done = std::panic::catch_unwind(|| show(args));
    std::panic::set_hook(report);
    done.unwrap_or_else(|panic| {
        let said = (panic.downcast_ref::<String>().map(String::as_str))
            .or_else(|| panic.downcast_ref::<&str>().copied())
            .unwrap_or("a decoder gave up");
        let told = format!(
            "polars gave up: {said}. The file is damaged (make it again), or polars cannot do what \
             was asked of it"
        );
        Err(ReportError::input(&args.path, told))
    })
}

fn show(args: &InspectArgs) -> Result<()> {
    let tables = open::open(&args.path)?;
    if let Some(query) = &args.sql {
        return print::frame(&answer(&tables, query)?, args.json);
    }
    let sections = glance::sections(&args.path, &tables)?;
    print::sections(&args.path, &sections, args.json)
}
