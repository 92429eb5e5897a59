//! Same seed, same bits: whatever the threads, run for run, and cell by cell.

use crate::program::{Place, TINY, bake_tiny, bytes_below, cornell, done};

/// Everything that a run holds, manifest and plan too, but for the folder's own name.
#[test]
fn one_thread_and_two() {
    let place = Place::new();
    let bake = |name: &str, threads: &str| {
        bake_tiny(&cornell(), &place.name(name), &["--threads", threads]);
        bytes_below(&place.path(name))
    };
    let (one, two, again) = (bake("one", "1"), bake("two", "2"), bake("again", "2"));
    let names: Vec<&str> = one.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(
        names,
        [
            "lock",
            "model/metrics.arrow",
            "model/tree.arrow",
            "model/weights.arrow",
            "rounds/000/fits/cell=000000/metrics.arrow",
            "rounds/000/fits/cell=000000/steps.arrow",
            "rounds/000/fits/cell=000000/weights.arrow",
            "rounds/000/fits/cell=000001/metrics.arrow",
            "rounds/000/fits/cell=000001/steps.arrow",
            "rounds/000/fits/cell=000001/weights.arrow",
            "rounds/000/judged.json",
            "rounds/000/plan.json",
            "rounds/000/tasks.parquet",
            "rounds/000/tasks/00000.json",
            "run.json",
            "samples/cell=000000/part-00000.parquet",
            "samples/cell=000001/part-00000.parquet",
            "test/part-00000.parquet",
        ]
    );
    for ((name, one), ((_, two), (_, again))) in one.iter().zip(two.iter().zip(&again)) {
        assert!(one == two, "{name}: one thread and two");
        assert!(two == again, "{name}: two runs");
    }
}

/// So are rounds: cells that are split, and fits that go on from earlier ones.
#[test]
fn rounds_on_one_thread_and_two() {
    let place = Place::new();
    let bake = |name: &str, threads: &str| {
        let (scene, run) = (cornell(), place.name(name));
        let more = ["--rounds", "2", "--target", "0.001", "--most-cells", "4"];
        let tiny = &TINY[..TINY.len() - 2];
        let given = ["bake", &scene, "-o", &run, "--threads", threads];
        done(&[&given[..], tiny, &more].concat());
        bytes_below(&place.path(name))
    };
    let (one, two) = (bake("one", "1"), bake("two", "2"));
    let plan = std::fs::read_to_string(place.path("one/rounds/001/plan.json")).unwrap();
    assert!(plan.contains("\"earlier\": {") || plan.contains("\"earlier\":{"));
    assert_eq!(one.len(), two.len());
    for ((name, one), (_, two)) in one.iter().zip(&two) {
        assert!(one == two, "{name}: one thread and two");
    }
}

/// Another seed gives other samples: the test above compares something.
#[test]
fn another_seed() {
    let place = Place::new();
    let bake = |name: &str, seed: &str| {
        bake_tiny(&cornell(), &place.name(name), &["--seed", seed]);
        bytes_below(&place.path(&format!("{name}/samples")))
    };
    let (one, two) = (bake("one", "1"), bake("two", "2"));
    assert_eq!(one.len(), two.len());
    assert!(one.iter().zip(&two).all(|(a, b)| a.0 == b.0 && a.1 != b.1));
}

/// A cell extracted alone is that cell of the whole run.
#[test]
fn a_cell_alone() {
    let place = Place::new();
    let extract = |name: &str, more: &[&str]| {
        let (scene, run) = (cornell(), place.name(name));
        done(&[&["extract", &scene, "-o", &run], &TINY[..], more].concat());
        bytes_below(&place.path(&format!("{name}/samples")))
    };
    let whole = extract("whole", &[]);
    let alone = extract("alone", &["--cell", "1"]);
    assert_eq!(whole.len(), 2);
    assert_eq!(alone, whole[1..]);
}

/// Extract and train one after the other make the model that a bake makes.
#[test]
fn stage_by_stage() {
    let place = Place::new();
    let (scene, run) = (cornell(), place.name("stages"));
    done(&[&["extract", &scene, "-o", &run], &TINY[..]].concat());
    done(&["train", &run]);
    bake_tiny(&scene, &place.name("bake"), &[]);
    assert!(bytes_below(&place.path("stages")) == bytes_below(&place.path("bake")));
}

/// A bake that lost parts and model goes on and ends with the same bits; nothing that was
/// there is written again.
#[test]
fn resumed() {
    let place = Place::new();
    let run = place.name("run");
    bake_tiny(&cornell(), &run, &[]);
    let before = bytes_below(&place.path("run"));
    let kept = place.path("run/samples/cell=000000/part-00000.parquet");
    let modified = || {
        std::fs::metadata(&kept)
            .and_then(|m| m.modified())
            .expect("a time")
    };
    let time = modified();
    std::fs::remove_dir_all(place.path("run/model")).expect("the model");
    std::fs::remove_dir_all(place.path("run/samples/cell=000001")).expect("a cell");
    bake_tiny(&cornell(), &run, &["--resume"]);
    assert!(bytes_below(&place.path("run")) == before);
    assert_eq!(modified(), time);
}
