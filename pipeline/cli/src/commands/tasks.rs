//! `rrf plan`, `rrf task`, `rrf commit`: the rounds of a bake as tasks that any scheduler runs.

use super::bake::{config, print_evaluation};
use crate::args::{CommitArgs, PlanArgs, TaskArgs};
use crate::failure::BadInput;
use crate::run_location::RunLocation;
use crate::scene_file;
use rrf_bake::{BakeError, Next, RoundPlan, Run, SHARD_TASKS, SamplingContext, Task, TaskKind};
use rrf_remote::is_url;
use rrf_store::layout::{TEST, task_table_path};
use rrf_store::task_table::{TaskRow, read_tasks};
use rrf_trace::Tracer;
use std::path::{Path, PathBuf};

/// Plans the first round of a new run, or writes the task table of the next round.
pub fn plan(args: &PlanArgs) -> anyhow::Result<()> {
    let location = RunLocation::whole(args.output.as_ref().unwrap_or(&args.input))?;
    let run = match &args.output {
        Some(_) => {
            let asked = &args.settings;
            let scene = scene_file::load(&args.input, &asked.scene)?;
            let config = config(asked, &scene)?;
            let unlit = scene.unlit();
            let tracer = Tracer::new(&unlit)?;
            let context = SamplingContext::new(&unlit, &tracer, &config)?;
            let run = Run::create(location.folder(), &scene, &config, args.resume)?;
            rrf_bake::plan_first(&run, &context)?;
            run
        }
        None => Run::open_to_work(location.folder())?,
    };
    let Some(plan) = run.progress()?.todo else {
        match args.json {
            true => println!("{}", serde_json::json!({"ended": true, "tasks": []})),
            false if args.missing => {}
            false => println!("nothing to do: the bake has ended"),
        }
        return Ok(());
    };
    // again, should it have been lost
    run.write_plan(&plan)?;
    let path = task_table_path(&run.folder, plan.round);
    let all = read_tasks(&path, &run.facts())?;
    location.push()?;
    let mut listed = Vec::new();
    for (row, task) in all.iter().zip(run.tasks(&plan)?) {
        if !(args.missing && run.is_done(&task)?) {
            listed.push(row);
        }
    }
    if args.json {
        println!(
            "{}",
            serde_json::to_string(&summary(&plan, &path, &listed))?
        );
    } else if args.missing {
        listed.iter().for_each(|row| println!("{}", row.task_id));
    } else {
        let seconds: f64 = all.iter().map(|row| row.seconds).sum();
        println!(
            "round {}: {} tasks, about {seconds:.0} core seconds: {}",
            plan.round,
            all.len(),
            path.display()
        );
    }
    Ok(())
}

fn summary(plan: &RoundPlan, path: &Path, listed: &[&TaskRow]) -> serde_json::Value {
    let tasks: Vec<serde_json::Value> = listed
        .iter()
        .map(|row| {
            serde_json::json!({
                "task_id": row.task_id, "stage": row.stage, "round": row.round,
                "cell_id": row.cell_id, "part": row.part, "input_hash": row.input_hash,
                "seconds": row.seconds, "memory": row.memory,
            })
        })
        .collect();
    serde_json::json!({"ended": false, "round": plan.round, "plan": path, "tasks": tasks})
}

/// Performs one task of a plan, or finds that it is done.
pub fn task(args: &TaskArgs) -> anyhow::Result<()> {
    let (run_path, round) = run_and_round(&args.plan)?;
    let index = index(args)?;
    let own = format!(
        "rounds/{round:03}/tasks/{:05}.json",
        index as usize / SHARD_TASKS
    );
    let first = format!("rounds/{round:03}/tasks/00000.json");
    let location = RunLocation::task(&run_path)?;
    location.pull(|name| name == "run.json" || name == own || name == first)?;
    let run = Run::open(location.folder())?;
    let job = run.read_job(round, index)?.map_err(|tasks| {
        BadInput(format!(
            "{}: task {index}: the plan has tasks 0 to {}",
            args.plan.display(),
            tasks.saturating_sub(1)
        ))
    })?;
    let (needed, task) = (job.files(), &job.task);
    location.pull(|name| needed.iter().any(|start| name.starts_with(start)))?;
    if run.is_done(task)? {
        println!("{}: done already", describe(task));
        return Ok(());
    }
    match task.kind {
        TaskKind::Extract => {
            let scene = run.load_scene()?.unlit();
            let tracer = Tracer::new(&scene)?;
            let context = SamplingContext::new(&scene, &tracer, &run.config)?;
            rrf_bake::perform(&run, &job, Some(&context), args.memory, None)?;
        }
        TaskKind::Train => match rrf_bake::perform(&run, &job, None, args.memory, None) {
            // it can succeed later
            Err(error @ BakeError::NotExtracted { .. }) => {
                anyhow::bail!("task {index} waits for an extraction: {error}")
            }
            done => done?,
        },
    }
    location.push()?;
    println!("{}: done", describe(task));
    Ok(())
}

/// Commits a round and plans the next one.
pub fn commit(args: &CommitArgs) -> anyhow::Result<()> {
    let location = RunLocation::existing(&args.run)?;
    let run = Run::open_to_work(location.folder())?;
    let Some(plan) = run.progress()?.todo else {
        if !args.json {
            println!("nothing to commit: the bake has ended");
        } else {
            println!("{}", serde_json::json!({"ended": true}));
        }
        return Ok(());
    };
    let (evaluation, next) = rrf_bake::evaluate_round(&run, &plan, &())?;
    location.push()?;
    let (ended, text) = match &next {
        Next::Stop(stop) => (true, stop.text(plan.round + 1)),
        Next::Round(next) => {
            let path = task_table_path(&run.folder, next.round);
            (
                false,
                format!("the next round is planned: {}", path.display()),
            )
        }
    };
    if args.json {
        let (error, se) = evaluation.error();
        let report = serde_json::json!({
            "round": plan.round, "ended": ended, "cells": evaluation.cells.len(),
            "relative_error": error, "relative_error_se": se,
            "held_out_error": evaluation.relative_error, "held_out_error_se": evaluation.relative_error_se,
            "target": run.config.target, "target_met": evaluation.meets(f64::from(run.config.target)),
            "stop": ended.then_some(&text),
        });
        println!("{report}");
        return Ok(());
    }
    print_evaluation(&evaluation, run.config.target);
    println!("round {} is committed: {text}", plan.round);
    Ok(())
}

fn describe(task: &Task) -> String {
    match task.part {
        Some(part) if task.cell == TEST => format!("extract test rows, part {part}"),
        Some(part) => format!("extract cell {} part {part}", task.cell),
        None => format!("train cell {}", task.cell),
    }
}

/// The run and the round of RUN/rounds/000/tasks.parquet.
fn run_and_round(plan: &Path) -> Result<(PathBuf, u32), BadInput> {
    let path = match is_url(plan) {
        true => plan.into(),
        false => std::path::absolute(plan).unwrap_or_else(|_| plan.into()),
    };
    let text = path.to_string_lossy();
    let parts: Vec<&str> = text.rsplitn(4, '/').collect();
    let [_, round, "rounds", run] = parts.as_slice() else {
        return Err(not_a_plan(plan));
    };
    let here = is_url(plan) || Path::new(run).join("run.json").exists();
    match (round.parse(), here) {
        (Ok(round), true) => Ok((PathBuf::from(run), round)),
        _ => Err(not_a_plan(plan)),
    }
}

fn not_a_plan(plan: &Path) -> BadInput {
    BadInput(format!(
        "{}: no plan of a run: `rrf plan` writes RUN/rounds/000/tasks.parquet",
        plan.display()
    ))
}

/// The index given, or what Slurm (array task) or Kubernetes (indexed job) gives.
fn index(args: &TaskArgs) -> Result<u32, BadInput> {
    if let Some(index) = args.index {
        return Ok(index);
    }
    for name in ["SLURM_ARRAY_TASK_ID", "JOB_COMPLETION_INDEX"] {
        if let Ok(text) = std::env::var(name) {
            let bad = || {
                BadInput(format!(
                    "{name}={text} with --offset {}: not an index from 0 to {}",
                    args.offset,
                    u32::MAX
                ))
            };
            let index: u32 = text.parse().map_err(|_| bad())?;
            return index.checked_add(args.offset).ok_or_else(bad);
        }
    }
    Err(BadInput(
        "no task: give --index, or run inside a Slurm array (SLURM_ARRAY_TASK_ID) or a \
         Kubernetes indexed job (JOB_COMPLETION_INDEX)"
            .into(),
    ))
}
