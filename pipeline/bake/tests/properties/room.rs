//! A bake of the Cornell box that takes milliseconds.

use rrf_bake::{BakeConfig, Preset, RoundPlan, Run, SamplingContext};
use rrf_extract::Region;
use rrf_scene::{LoadOptions, Scene};
use rrf_trace::Tracer;
use std::collections::BTreeMap;
use std::path::Path;

/// Runs `work` with a new run folder, its first plan, and the scene ready to be sampled.
pub fn with_run<T>(work: impl FnOnce(&Run, &RoundPlan, &SamplingContext) -> T) -> T {
    let path = Path::new(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../scenes/cornell-box/scene.pbrt"
    ));
    let scene: Scene = rrf_scene::load(path, &LoadOptions::default()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let run = Run::create(folder.path(), &scene, &config(), false).unwrap();
    let scene = scene.unlit();
    let tracer = Tracer::new(&scene).unwrap();
    let context = SamplingContext::new(&scene, &tracer, &run.config).unwrap();
    let plan = rrf_bake::plan_first(&run, &context).unwrap();
    work(&run, &plan, &context)
}

fn config() -> BakeConfig {
    let light_box = Region {
        minimum: [-0.6, 1.3, -0.6],
        maximum: [0.6, 1.8, 0.6],
    };
    let mut config = BakeConfig::preset(Preset::Preview, light_box, 5);
    config.extract.candidates = 4096;
    config.extract.cells = 3;
    config.extract.rows = 300;
    config.extract.fewest_rows = 100;
    config.extract.paths = 2;
    config.train.iterations = 3;
    config
}

/// Every file of a run with its bytes, but for those with wall times.
pub fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let entry = entry.unwrap();
        let name = entry.file_name().into_string().unwrap();
        if entry.file_type().unwrap().is_dir() {
            let inner = files(&entry.path()).into_iter();
            found.extend(inner.map(|(inner, bytes)| (format!("{name}/{inner}"), bytes)));
        } else if name != "seconds.json" {
            found.insert(name, std::fs::read(entry.path()).unwrap());
        }
    }
    found
}
