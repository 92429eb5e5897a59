//! `rrf bake --method transfer`.

use crate::args::BakeArgs;
use crate::failure::require_target;
use crate::memory::check_transfer;
use crate::progress::Watching;
use crate::run_location::RunLocation;
use crate::scene_file;
use crate::stats::processor_time;
use rrf_bake::{TransferOutcome, TransferSummary};
use rrf_store::model::{TRANSFER_TABLES, model_table_path};
use serde_json::{Value, json};
use std::path::Path;
use std::time::Instant;

/// What a bake cost.
struct Cost {
    seconds: f64,
    processor: f64,
    bytes: u64,
}

/// Bakes a scene's transfer and prints how it went.
pub fn bake(args: &BakeArgs, watching: Watching) -> anyhow::Result<()> {
    let (outcome, cost, target) = work(args, watching)?;
    match args.json {
        true => println!("{:#}", told(args, &outcome, &cost, target)),
        false => print(args, &outcome, &cost, target),
    }
    let error = outcome.summary.test.relative_error;
    let met = !args.require_target || meets(&outcome, target);
    Ok(require_target(&args.output, (error, target), met)?)
}

/// Bakes a scene's transfer; the result as JSON.
pub fn baked(args: &BakeArgs, watching: Watching) -> anyhow::Result<Value> {
    let (outcome, cost, target) = work(args, watching)?;
    Ok(told(args, &outcome, &cost, target))
}

fn meets(outcome: &TransferOutcome, target: f32) -> bool {
    outcome.summary.meets(target)
}

fn work(args: &BakeArgs, watching: Watching) -> anyhow::Result<(TransferOutcome, Cost, f32)> {
    let start = Instant::now();
    let scene = scene_file::load(&args.scene, &args.settings.scene)?;
    let config = args.settings.transfer_config(&scene)?;
    check_transfer(config.rows, config.most_memory())?;
    let location = RunLocation::whole(&args.output)?;
    let folder = location.folder().to_path_buf();
    let watch = watching(location)?;
    let outcome = rrf_bake::bake_scene_transfer(&scene, &config, &folder, args.resume, &*watch)?;
    let cost = Cost {
        seconds: start.elapsed().as_secs_f64(),
        processor: processor_time().as_secs_f64(),
        bytes: bytes(&folder)?,
    };
    Ok((outcome, cost, config.target))
}

/// Bytes of the model's tables.
fn bytes(folder: &Path) -> anyhow::Result<u64> {
    let mut sum = 0;
    for table in TRANSFER_TABLES {
        sum += std::fs::metadata(model_table_path(folder, table))?.len();
    }
    Ok(sum)
}

fn told(args: &BakeArgs, outcome: &TransferOutcome, cost: &Cost, target: f32) -> Value {
    json!({
        "run": args.output.display().to_string(),
        "method": "transfer",
        "target": target,
        "target_met": meets(outcome, target),
        "was_finished": outcome.was_finished,
        "relative_error": outcome.summary.test.relative_error,
        "relative_error_se": outcome.summary.test.relative_error_se,
        "cells": outcome.summary.cells,
        "model": outcome.summary,
        "model_bytes": cost.bytes,
        "processor_seconds": cost.processor,
        "seconds": cost.seconds,
    })
}

fn print(args: &BakeArgs, outcome: &TransferOutcome, cost: &Cost, target: f32) {
    let TransferSummary {
        test,
        held_out_error,
        held_out_error_se,
        judged,
        rows,
        cells,
        nets,
        missing,
        patches,
        columns,
        lights,
    } = outcome.summary;
    println!(
        "{patches} patches, {columns} columns; {rows} rows under {lights} lights; {cells} cells, {nets} of them nets"
    );
    println!(
        "relative error: {:.2} % ± {:.2} % (target {:.2} %) on {} test rows, which no cell was fitted to",
        100.0 * test.relative_error,
        100.0 * test.relative_error_se,
        100.0 * target,
        test.test_rows,
    );
    println!(
        "  median {:.2} %, 95th percentile {:.2} %; the worst 1 % of the rows make {:.0} % of the squared error",
        100.0 * test.median_error,
        100.0 * test.percentile_95,
        100.0 * test.worst_share,
    );
    println!(
        "  trusted answers: {:.1} % of the rows, relative error {:.2} %",
        100.0 * test.trusted_share,
        100.0 * test.trusted_error,
    );
    println!(
        "relative error on held-out rows: {:.2} % ± {:.2} % on {judged} rows where light falls steeply, one \
         standard error added a cell; {missing} of {cells} cells miss the target",
        100.0 * held_out_error,
        100.0 * held_out_error_se,
    );
    println!(
        "  relative error: {}, Monte Carlo noise removed",
        rrf_metrics::relative::FORMULA
    );
    let done = match outcome.was_finished {
        true => "finished before",
        false => "baked",
    };
    println!(
        "{done}: model of {:.2} MB, {:.1} CPU seconds, {:.1} s: {}",
        cost.bytes as f64 / 1e6,
        cost.processor,
        cost.seconds,
        args.output.display()
    );
}
