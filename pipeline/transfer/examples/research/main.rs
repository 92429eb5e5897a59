//! What direct-to-indirect transfer costs and how far it carries.
//!
//! ```text
//! cargo run --release -p rrf-transfer --example research -- SETUP [SCENE] MODE
//! ```
//!
//! SETUP: `salon PATH`, `overhead`, `free`, `free15`. `oracle=TABLE.csv`: raw rows against a table.
//! Results: `docs/science/transfer.md`.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod clock;
mod model;
mod oracle;
mod raw;
mod setup;
mod truth;

use rrf_trace::Tracer;
use rrf_transfer::{CellChoice, TransferConfig};
use setup::{Places, Setup, load_whole};
use truth::Truth;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let name = words.first().map_or("overhead", String::as_str);
    let path = words.iter().find(|w| w.ends_with(".glb"));
    let setup = Setup::new(name, path.map(String::as_str));
    let tracer = Tracer::new(&setup.scene).expect("a scene that can be traced");
    let number = |key: &str, otherwise: usize| {
        let found = words
            .iter()
            .find_map(|w| w.strip_prefix(&format!("{key}=")));
        found.map_or(otherwise, |v| v.parse().expect("a number"))
    };
    let tables: Vec<&str> = (words.iter())
        .filter_map(|w| w.strip_prefix("oracle="))
        .collect();
    if !tables.is_empty() {
        let sky = words.iter().find_map(|w| w.strip_prefix("sky="));
        let whole = load_whole(path.map(String::as_str), sky);
        let scene = match words.iter().any(|w| w == "unlit") {
            true => whole.unlit(),
            false => whole,
        };
        let tracer = Tracer::new(&scene).expect("a scene that can be traced");
        let plan = oracle::Plan {
            patches: number("patches", 2_000),
            paths: number("paths", 2_048) as u32,
            samples: number("samples", 8) as u32,
            directions: number("directions", 4) as u32,
            gloss: number("gloss", 30) as f32 / 100.0,
            finer: words.iter().any(|w| w == "finer"),
        };
        let model = words.iter().any(|w| w == "model").then(|| {
            let places = Places::new(&setup, &tracer);
            oracle::bake(&tracer, &places, &config(&words))
        });
        let run = |table: &&str| oracle::run(&tracer, table, &plan, model.as_ref());
        return tables.iter().for_each(run);
    }
    let places = Places::new(&setup, &tracer);
    let (points, lights) = (number("points", 240), number("lights", 24));
    let file = std::env::temp_dir().join(format!("transfer-{name}-{points}-{lights}.truth"));
    let start = clock::cpu();
    let truth = Truth::new(
        &tracer,
        places.points(points, 1),
        places.lights(lights, 1),
        number("spp", 2_048) as u32,
        &file,
    );
    println!(
        "{name}: truth {:.1} CPU s, noise {:.2} %",
        clock::cpu() - start,
        100.0 * truth.noise()
    );
    let paths = number("paths", 2_048) as u32;
    let samples = number("samples", 8) as u32;
    let settings = |count| (count, paths, samples, number("directions", 4) as u32);
    if words.iter().any(|w| w == "raw") {
        let chosen = [settings(number("patches", 8_000))];
        raw::run(&setup.scene, &tracer, &truth, &chosen);
    }
    let has = |word: &str| words.iter().any(|w| w == word);
    if has("model") {
        model_run(&tracer, &places, &truth, &words);
    }
}

/// The library's model by the words of the command line.
fn model_run(tracer: &Tracer, places: &Places, truth: &Truth, words: &[String]) {
    let choices: &[CellChoice] = match text(words, "choice") {
        Some("nets") => &[CellChoice::Nets],
        Some("nodes") => &[CellChoice::Nodes],
        Some("all") => &[CellChoice::Nodes, CellChoice::Nets, CellChoice::Best],
        _ => &[CellChoice::Best],
    };
    let ensemble = text(words, "ensemble").map_or(330, |v| v.parse().expect("a number"));
    model::run(tracer, places, truth, ensemble, &config(words), choices);
}

/// The value of a key, the last if there are several.
fn text<'w>(words: &'w [String], key: &str) -> Option<&'w str> {
    let key = format!("{key}=");
    words.iter().rev().find_map(|w| w.strip_prefix(&key))
}

/// Settings by the words; those of the library where they say nothing.
fn config(words: &[String]) -> TransferConfig {
    let number = |key: &str, otherwise: f64| {
        text(words, key).map_or(otherwise, |v| v.parse().expect("a number"))
    };
    let mut config = TransferConfig::default();
    config.patches.count = number("patches", 2_000.0) as usize;
    config.rows = number("rows", 20_000.0) as usize;
    config.paths.paths = number("row-paths", 256.0) as u32;
    config.candidates = number("candidates", 3.0) as f32;
    config.finer_patches = number("finer", 1.5) as f32;
    config.patch_error = number("patch-error", 0.1) as f32;
    config.rounds = number("rounds", 1.0) as u32;
    config.target = number("target", 0.05) as f32;
    config.pool = number("pool", 16.0) as f32;
    config.least_rows = number("least", 64.0) as usize;
    config.cell_rows = number("cell-rows", 400.0) as usize;
    config.cell_rank = number("cell-rank", 16.0) as usize;
    config.patience = number("patience", 1.25) as f32;
    config.cell_error = number("cell-error", 0.01);
    config.cluster_error = number("cluster-error", 0.003);
    config.left_out = number("left-out", 0.1);
    config.nodes = number("nodes", 96.0) as usize;
    config.net.units = number("units", 16.0) as usize;
    config.net.ridge = number("ridge", 1e-4);
    config.net.decay = number("decay", 0.1);
    config.local.neighbours = number("neighbours", 32.0) as usize;
    config.local.view = number("view", 0.15) as f32;
    config
}
