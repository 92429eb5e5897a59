//! What the fuzz targets share: each writes the bytes where a reader looks for them and reads.
//!
//! A reader may refuse whatever it likes; it may not panic, hang, or ask for much memory.
//! Panics inside the decoders of arrow and parquet that `rrf_store` turns into errors are not
//! findings, so the hook that libFuzzer's crate aborts from is taken out; a panic that leaves a
//! reader still ends the process.

use rrf_bake::Run;
use rrf_scene::LoadOptions;
use rrf_store::guard::Limits;
use rrf_store::layout::{cell_folder, fit_folder, model_folder, part_path, round_folder};
use rrf_store::manifest::{RunFacts, RunManifest};
use rrf_store::{model, parts, points, task_table};
use std::path::{Path, PathBuf};
use std::sync::{Once, OnceLock};

/// The run that the seeds of all tables are of.
const RUN: &str = include_str!("../seeds/run_json/run.json");

/// A scene file of a name.
pub fn scene(name: &str, bytes: &[u8]) {
    let path = write(&folder().join("scene").join(name), bytes);
    let _ = rrf_scene::load(&path, &LoadOptions::default());
}

/// The first part of the first cell.
pub fn part(bytes: &[u8]) {
    write(&part_path(folder(), 0, 0), bytes);
    let _ = parts::read_part(folder(), 0, 0, facts());
    let _ = parts::part_task(folder(), 0, 0, facts());
    let _ = parts::read_cell(folder(), 0, facts());
}

/// One table of the model, `tree`, `weights` or `metrics`.
pub fn model(table: &str, bytes: &[u8]) {
    write(&model_folder(folder()).join(format!("{table}.arrow")), bytes);
    match table {
        "tree" => drop(model::read_tree(folder(), facts())),
        "weights" => {
            let _ = model::read_weights(folder(), facts());
            // the same table, of one cell
            let fit = fit_folder(folder(), 0, 0);
            write(&fit.join("weights.arrow"), bytes);
            let _ = model::fit_task(&fit, facts());
        }
        _ => drop(model::read_metrics(folder(), facts())),
    }
}

/// A table of points; Parquet begins with PAR1.
pub fn points(bytes: &[u8]) {
    let name = match bytes.starts_with(b"PAR1") {
        true => "points.parquet",
        false => "points.arrow",
    };
    let path = write(&folder().join(name), bytes);
    let _ = points::read_points(&path, Limits::default());
}

/// The tasks of a round.
pub fn tasks(bytes: &[u8]) {
    let path = write(&folder().join("tasks.parquet"), bytes);
    let _ = task_table::read_tasks(&path, facts());
}

/// The manifest.
pub fn run_json(bytes: &[u8]) {
    let run = folder().join("run");
    write(&RunManifest::path(&run), bytes);
    let _ = Run::open(&run);
}

/// A round's plan, its tasks and their hashes.
pub fn plan_json(bytes: &[u8]) {
    static RUN_OPEN: OnceLock<Option<Run>> = OnceLock::new();
    let run = RUN_OPEN.get_or_init(|| {
        let path = folder().join("planned");
        write(&RunManifest::path(&path), RUN.as_bytes());
        Run::open(&path).ok()
    });
    let run = run.as_ref().expect("the seed run opens");
    write(&round_folder(&run.folder, 0).join("plan.json"), bytes);
    if let Ok(Some(plan)) = run.read_plan(0) {
        let _ = rrf_bake::tasks(run, &plan);
    }
}

fn facts() -> &'static RunFacts {
    static FACTS: OnceLock<RunFacts> = OnceLock::new();
    FACTS.get_or_init(|| {
        let manifest: RunManifest = serde_json::from_str(RUN).expect("the seed run is one");
        manifest.facts()
    })
}

fn write(path: &Path, bytes: &[u8]) -> PathBuf {
    std::fs::write(path, bytes).expect("the scratch folder can be written");
    path.into()
}

/// A scratch folder, in memory where there is one.
fn folder() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    static HOOK: Once = Once::new();
    HOOK.call_once(|| std::panic::set_hook(Box::new(|_| ())));
    FOLDER.get_or_init(|| {
        let memory = Path::new("/dev/shm");
        let base = match memory.is_dir() {
            true => memory.into(),
            false => std::env::temp_dir(),
        };
        let folder = base.join(format!("rrf-fuzz-{}", std::process::id()));
        let inner = [
            folder.join("scene"),
            cell_folder(&folder, 0),
            model_folder(&folder),
            fit_folder(&folder, 0, 0),
            folder.join("run"),
            round_folder(&folder.join("planned"), 0),
        ];
        for path in inner {
            std::fs::create_dir_all(path).expect("a scratch folder");
        }
        folder
    })
}
