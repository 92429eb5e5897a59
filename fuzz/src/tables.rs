//! Tables and the small files of a run.

use super::{folder, scene, write};
use rrf_bake::Run;
use rrf_store::Limits;
use rrf_store::layout::{
    cell_folder, chapter_path, fit_folder, model_folder, part_path, round_folder,
};
use rrf_store::manifest::{RunFacts, RunManifest};
use rrf_store::{model, parts, points, task_table};
use std::path::Path;
use std::sync::OnceLock;

/// The run that the seeds of all tables are of; a byte that says so goes before.
const RUN: &[u8] = include_bytes!("../seeds/small/run.json");

/// Makes what readers look into.
pub fn make_folders(folder: &Path) {
    let inner = [
        cell_folder(folder, 0),
        model_folder(folder),
        fit_folder(folder, 0, 0),
        folder.join("run"),
        round_folder(&folder.join("planned"), 0).join("tasks"),
    ];
    for path in inner {
        std::fs::create_dir_all(path).expect("a scratch folder");
    }
}

/// A Parquet table, which one by the first byte.
pub fn parquet(bytes: &[u8]) {
    match bytes.split_first() {
        Some((b'0', rest)) => part(rest),
        Some((b'1', rest)) => points("points.parquet", rest),
        Some((b'2', rest)) => tasks(rest),
        _ => (),
    }
}

/// An Arrow table, which one by the first byte.
pub fn arrow(bytes: &[u8]) {
    match bytes.split_first() {
        Some((b'0', rest)) => tree(rest),
        Some((b'1', rest)) => weights(rest),
        Some((b'2', rest)) => metrics(rest),
        Some((b'3', rest)) => points("points.arrow", rest),
        Some((b'4', rest)) => steps(rest),
        _ => (),
    }
}

/// Small texts: OBJ, manifest, plan, judgement, tasks with what they need.
pub fn small(bytes: &[u8]) {
    match bytes.split_first() {
        Some((b'0', rest)) => scene("scene.obj", rest),
        Some((b'1', rest)) => run_json(rest),
        Some((b'2', rest)) => plan_json(rest),
        Some((b'3', rest)) => judged_json(rest),
        Some((b'4', rest)) => chapter_json(rest),
        _ => (),
    }
}

/// The first part of the first cell, whole and batch by batch.
fn part(bytes: &[u8]) {
    write(&part_path(folder(), 0, 0), bytes);
    let _ = parts::read_part(folder(), 0, 0, facts());
    let _ = parts::part_task(folder(), 0, 0, facts());
    let _ = parts::read_cell(folder(), 0, facts());
}

fn tree(bytes: &[u8]) {
    write(&model_folder(folder()).join("tree.arrow"), bytes);
    drop(model::read_tree(folder(), facts()));
}

/// The weights of a model, and the same as one cell's fit.
fn weights(bytes: &[u8]) {
    write(&model_folder(folder()).join("weights.arrow"), bytes);
    let _ = model::read_weights(folder(), facts());
    let fit = fit_folder(folder(), 0, 0);
    write(&fit.join("weights.arrow"), bytes);
    let _ = model::fit_task(&fit, facts());
}

fn metrics(bytes: &[u8]) {
    write(&model_folder(folder()).join("metrics.arrow"), bytes);
    drop(model::read_metrics(folder(), facts()));
}

/// The steps of a cell's fit.
fn steps(bytes: &[u8]) {
    let fit = fit_folder(folder(), 0, 0);
    write(&fit.join("steps.arrow"), bytes);
    let _ = model::read_steps(&fit, facts());
}

fn points(name: &str, bytes: &[u8]) {
    let path = write(&folder().join(name), bytes);
    let _ = points::read_points(&path, Limits::default());
}

/// The tasks of a round.
fn tasks(bytes: &[u8]) {
    let path = write(&folder().join("tasks.parquet"), bytes);
    let _ = task_table::read_tasks(&path, facts());
}

/// The manifest.
fn run_json(bytes: &[u8]) {
    let run = folder().join("run");
    write(&RunManifest::path(&run), bytes);
    let _ = Run::open(&run);
}

/// A run whose rounds are forged.
fn planned() -> &'static Run {
    static RUN_OPEN: OnceLock<Option<Run>> = OnceLock::new();
    let run = RUN_OPEN.get_or_init(|| {
        let path = folder().join("planned");
        write(&RunManifest::path(&path), run_seed());
        Run::open(&path).ok()
    });
    run.as_ref().expect("the seed run opens")
}

/// How a round was judged.
fn judged_json(bytes: &[u8]) {
    let run = planned();
    write(&round_folder(&run.folder, 0).join("judged.json"), bytes);
    let _ = run.read_evaluated(0);
}

/// Tasks as a worker reads them, with the check of their hashes.
fn chapter_json(bytes: &[u8]) {
    let run = planned();
    write(&chapter_path(&run.folder, 0, 0), bytes);
    for task in 0..4 {
        let _ = run.read_job(0, task);
    }
}

/// A round's plan, its tasks and their hashes.
fn plan_json(bytes: &[u8]) {
    let run = planned();
    write(&round_folder(&run.folder, 0).join("plan.json"), bytes);
    if let Ok(Some(plan)) = run.read_plan(0) {
        let _ = run.tasks(&plan);
    }
}

fn facts() -> &'static RunFacts {
    static FACTS: OnceLock<RunFacts> = OnceLock::new();
    FACTS.get_or_init(|| {
        let manifest: RunManifest =
            serde_json::from_slice(run_seed()).expect("the seed run is one");
        manifest.facts()
    })
}

fn run_seed() -> &'static [u8] {
    RUN.get(1..).unwrap_or_default()
}
