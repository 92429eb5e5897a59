//! `rrf bake`, `rrf extract`, `rrf train`.

use super::transfer;
use crate::args::{BakeArgs, ExtractArgs, TrainArgs, TrainMode};
use crate::failure::require_target;
use crate::print;
use crate::progress::{Bars, Watching};
use crate::run_location::RunLocation;
use crate::scene_file;
use crate::stats::processor_time;
use rrf_bake::settings::Method;
use rrf_bake::{
    BakeConfig, BakeError, BakeOutcome, Evaluation, Next, Run, SamplingContext, Settings, Watch,
};
use rrf_extract::{Census, Region};
use rrf_scene::Scene;
use rrf_trace::Tracer;
use serde_json::{Value, json};
use std::time::Instant;

/// Bakes a scene.
pub fn bake(args: &BakeArgs, quiet: bool) -> anyhow::Result<()> {
    let watching = |location| {
        let bars = Bars::new(quiet || args.json, &args.bounds)?;
        bars.begin_bake(args.settings.target);
        Ok(Box::new(bars.keeping(location)) as Box<dyn Watch>)
    };
    if args.settings.method == Method::Transfer {
        return transfer::bake(args, &watching);
    }
    let start = Instant::now();
    let (ended, target) = nets(args, &watching)?;
    let evaluation = &ended.evaluation;
    if args.json {
        println!("{:#}", told(args, &ended, target, start));
    } else {
        print_census(&ended.census);
        print_evaluation(evaluation, target);
        println!(
            "{} rounds in {:.1} s, {}: {}",
            ended.rounds,
            start.elapsed().as_secs_f64(),
            ended.stop.text(ended.rounds),
            args.output.display()
        );
    }
    let met = !args.require_target || evaluation.meets(target.into());
    let error = (evaluation.error().0, target);
    Ok(require_target(&args.output, error, met)?)
}

/// Bakes a scene; the result as JSON.
pub fn baked(args: &BakeArgs, watching: Watching) -> anyhow::Result<Value> {
    if args.settings.method == Method::Transfer {
        return transfer::baked(args, watching);
    }
    let start = Instant::now();
    let (ended, target) = nets(args, watching)?;
    Ok(told(args, &ended, target, start))
}

/// Bakes nets that know the light; the outcome and the target.
fn nets(args: &BakeArgs, watching: Watching) -> anyhow::Result<(BakeOutcome, f32)> {
    let scene = scene_file::load(&args.scene, &args.settings.scene)?;
    let config = config(&args.settings, &scene)?;
    let location = RunLocation::whole(&args.output)?;
    let folder = location.folder().to_path_buf();
    let watch = watching(location)?;
    let ended = rrf_bake::bake(&scene, &config, &folder, args.resume, &*watch)?;
    Ok((ended, config.target))
}

fn told(args: &BakeArgs, ended: &BakeOutcome, target: f32, start: Instant) -> Value {
    let (error, se) = ended.evaluation.error();
    json!({
        "run": args.output.display().to_string(),
        "method": "nets",
        "target": target,
        "target_met": ended.evaluation.meets(target.into()),
        "stop": ended.stop.text(ended.rounds),
        "rounds": ended.rounds,
        "relative_error": error,
        "relative_error_se": se,
        "cells": ended.evaluation.cells.len(),
        "processor_seconds": processor_time().as_secs_f64(),
        "seconds": start.elapsed().as_secs_f64(),
    })
}

/// Loads, plans and extracts.
pub fn extract(args: &ExtractArgs, quiet: bool) -> anyhow::Result<()> {
    let bake = &args.bake;
    let asked = &bake.settings;
    let scene = scene_file::load(&bake.scene, &asked.scene)?;
    let location = RunLocation::whole(&bake.output)?;
    let config = config(asked, &scene)?;
    let unlit = scene.unlit();
    let folder = location.folder().to_path_buf();
    let watch = Bars::new(quiet, &bake.bounds)?.keeping(location);
    let halt = || watch.halted().is_some();
    let tracer = Tracer::new(&unlit)?.until(&halt);
    let context = SamplingContext::new(&unlit, &tracer, &config)?;
    let run = Run::create(&folder, &scene, &config, bake.resume)?;
    let first = rrf_bake::plan_first(&run, &context)?;
    let plan = run.progress()?.todo.unwrap_or(first);
    let only = (!args.cell.is_empty()).then_some(args.cell.as_slice());
    let last = plan.cells.len().saturating_sub(1) as u32;
    if let Some(&cell) = args.cell.iter().find(|&&cell| cell > last) {
        return Err(BakeError::NoSuchCell { cell, last }.into());
    }
    rrf_bake::extract_samples(&run, &plan, &context, only, &watch)?;
    print_census(&plan.census);
    println!(
        "{} cells planned: {}",
        plan.cells.len(),
        bake.output.display()
    );
    Ok(())
}

/// Trains and evaluates the round that is extracted.
pub fn train(args: &TrainArgs, quiet: bool) -> anyhow::Result<()> {
    let location = RunLocation::existing(&args.run)?;
    let mut run = Run::open_to_work(location.folder())?;
    run.config.train.mode = mode(args);
    let progress = run.progress()?;
    let Some(plan) = progress.todo else {
        let evaluated = progress.evaluated.ok_or_else(|| BakeError::NotExtracted {
            path: args.run.clone(),
            cell: 0,
        })?;
        println!("all rounds are trained");
        print_evaluation(&evaluated.evaluation, run.config.target);
        return Ok(());
    };
    let watch = Bars::new(quiet, &args.bounds)?.keeping(location);
    rrf_bake::train_nets(&run, &plan, &watch)?;
    let (evaluation, next) = rrf_bake::evaluate_round(&run, &plan, &watch)?;
    watch.push()?;
    print_evaluation(&evaluation, run.config.target);
    match next {
        Next::Stop(stop) => println!("{}", stop.text(plan.round + 1)),
        Next::Round(next) => println!(
            "round {} is planned, {} cells: continue with `rrf bake --resume`",
            next.round,
            next.cells.len()
        ),
    }
    Ok(())
}

/// Steps on a batch: enough for its minimum where the batch alone decides, a few where it only corrects
/// what earlier ones taught.
const BATCH_STEPS: [usize; 2] = [10, 3];

fn mode(args: &TrainArgs) -> rrf_train::Schedule {
    let batches = |steps| rrf_train::Batches {
        rows: args.batch as usize,
        steps,
    };
    let [online, recursive] = BATCH_STEPS;
    match args.mode {
        TrainMode::Local => rrf_train::Schedule::Local,
        TrainMode::Online => rrf_train::Schedule::Online(batches(online)),
        TrainMode::Recursive => rrf_train::Schedule::Recursive(batches(recursive)),
    }
}

/// What the settings mean for a scene. The box that lights may be in is reported where it was not given.
pub fn config(settings: &Settings, scene: &Scene) -> Result<BakeConfig, BakeError> {
    let config = settings.config(scene)?;
    if settings.light_box.is_none() {
        let Region { minimum, maximum } = config.extract.light_box;
        let corners = [minimum, maximum].concat();
        let corners: Vec<String> = corners.into_iter().map(print::short).collect();
        eprintln!(
            "no --light-box: lights may be in the middle 80 % of the scene, --light-box={}",
            corners.join(",")
        );
    }
    Ok(config)
}

fn print_census(census: &Census) {
    println!(
        "candidates: {} accepted; rejected: {} lights inside solids, {} points inside solids, \
         {} points that see nothing, {} on black surfaces{}",
        census.accepted,
        census.light_in_solid,
        census.point_in_solid,
        census.sees_nothing,
        census.black,
        match census.unseen {
            0 => String::new(),
            unseen => format!(", {unseen} not visible from the eye box"),
        }
    );
}

/// Prints the error of the whole model with its definition.
pub fn print_evaluation(evaluation: &Evaluation, target: f32) {
    let square = f64::from(target).powi(2);
    let missing = evaluation
        .cells
        .iter()
        .filter(|c| c.square_error > square)
        .count();
    if let Some(test) = evaluation.test {
        println!(
            "relative error: {:.2} % ± {:.2} % (target {:.2} %) on {} test rows, which no net was fitted to",
            100.0 * test.relative_error,
            100.0 * test.relative_error_se,
            100.0 * target,
            test.rows
        );
    }
    println!(
        "relative error on held-out rows: {:.2} % ± {:.2} % (target {:.2} %); {} of {} cells miss the target",
        100.0 * evaluation.relative_error,
        100.0 * evaluation.relative_error_se,
        100.0 * target,
        missing,
        evaluation.cells.len()
    );
    println!(
        "  relative error: {}, Monte Carlo noise removed",
        rrf_metrics::relative::FORMULA
    );
}
