//! Run folders that exist, are missing, are damaged or belong to something else: what is there
//! is never overwritten.

use crate::program::{
    OVERHEAD, Place, TINY, bake_tiny, bytes_below, cornell, done, oracle, refused,
};

const LIGHT: [&str; 4] = ["--light", "0.1,1.6,0.2", "--size", "16x16"];

fn bake<'a>(scene: &'a str, run: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&["bake", scene, "-o", run], &TINY[..], more].concat()
}

#[test]
fn boxes_of_lights_and_eyes_without_use() {
    let (place, scene) = (Place::new(), cornell());
    let run = place.name("run");
    let call = ["bake", &scene, "-o", &run, "--light-box", "5,5,5,6,6,6"];
    for method in ["nets", "transfer"] {
        refused(
            &[&call[..], &["--method", method]].concat(),
            &["light box 5,5,5,6,6,6", "outside the scene", "bounds"],
        );
    }
    for (eye_box, why) in [
        ("5,5,5,6,6,6", "outside the scene"),
        ("0.3,0.2,0.3,0.35,0.3,0.35", "inside a solid"),
    ] {
        let call = bake(&scene, &run, &["--eye-box", eye_box]);
        refused(&call, &["eye box", eye_box, why]);
    }
    assert!(place.holds(&[]), "a refused bake left something");
    // so the corrected call needs no --resume
    bake_tiny(&scene, &run, &[]);
}

#[test]
fn settings_out_of_range() {
    let (place, scene) = (Place::new(), cornell());
    for (option, value) in [
        ("--rows", "0"),
        ("--cells", "0"),
        ("--paths", "3"),
        ("--paths", "0"),
    ] {
        let run = place.name("run");
        let call = ["bake", &scene, "-o", &run, "--light-box", OVERHEAD];
        for method in [&["--method", "nets"][..], &[]] {
            refused(
                &[&call[..], method, &[option, value]].concat(),
                &[&option[2..], value],
            );
        }
        assert!(
            place.holds(&[]),
            "{option} {value}: a refused bake left something"
        );
    }
}

#[test]
fn existing_run() {
    let (place, scene) = (Place::new(), cornell());
    let run = place.name("run");
    bake_tiny(&scene, &run, &[]);
    let before = bytes_below(&place.path("run"));
    refused(
        &bake(&scene, &run, &[]),
        &[&run, "already holds a run", "--resume"],
    );
    let extract = [&["extract", &scene, "-o", &run], &TINY[..]].concat();
    refused(&extract, &["already holds a run"]);

    // with --resume, but asked for something else
    let other = |more: &[&str], words: &[&str]| {
        refused(&bake(&scene, &run, more), words);
        assert!(bytes_below(&place.path("run")) == before, "{more:?}");
    };
    other(&["--resume", "--seed", "7"], &["another seed", "1", "7"]);
    other(
        &["--resume", "--target", "0.5"],
        &["another configuration", "target 0.05", "target 0.5"],
    );
    let moved = [
        "bake",
        &scene,
        "-o",
        &run,
        "--resume",
        "--light-box",
        "0,1,0,1,1,1",
    ];
    let rest = "--method nets --rows 2000 --cells 2 --paths 4";
    let rest: Vec<&str> = rest.split(' ').collect();
    let words = ["another configuration", "extract.light_box"];
    refused(&[&moved[..], &rest].concat(), &words);

    let cell = [
        &["extract", &scene, "-o", &run, "--resume", "--cell", "9"],
        &TINY[..],
    ]
    .concat();
    refused(&cell, &["cell 9", "0 to 1"]);
    assert!(bytes_below(&place.path("run")) == before);
}

/// The scene file is another one than at the bake: neither a frame nor an answer.
#[test]
fn changed_scene() {
    let place = Place::new();
    let text = std::fs::read_to_string(cornell()).expect("the scene");
    let scene = place.write("scene.pbrt", &text);
    let run = place.name("run");
    bake_tiny(&scene, &run, &[]);
    let before = bytes_below(&place.path("run"));
    place.write(
        "scene.pbrt",
        text.replacen("0.725000 0.710000", "0.725000 0.500000", 1),
    );

    let words = [&run as &str, "scene", "changed"];
    let (picture, table, input) = (
        place.name("a.exr"),
        place.name("a.parquet"),
        oracle("cornell_free"),
    );
    refused(
        &[&["render", &run, "-o", &picture], &LIGHT[..]].concat(),
        &words,
    );
    refused(&["query", &run, "--points", &input, "-o", &table], &words);
    refused(&bake(&scene, &run, &["--resume"]), &[&run, "another scene"]);
    assert!(!place.path("a.exr").exists() && !place.path("a.parquet").exists());
    assert!(bytes_below(&place.path("run")) == before);
}

/// One byte of one part, in the middle of its values: training names the file.
#[test]
fn corrupted_part() {
    let (place, scene) = (Place::new(), cornell());
    let run = place.name("run");
    done(&[&["extract", &scene, "-o", &run], &TINY[..]].concat());
    let part = place.path("run/samples/cell=000001/part-00000.parquet");
    let whole = std::fs::read(&part).expect("a part");
    let middle = whole.len() / 2;
    for damage in ["flipped", "cut", "emptied", "text"] {
        let mut bytes = whole.clone();
        match damage {
            "flipped" => bytes[middle] ^= 0x10,
            "cut" => bytes.truncate(middle),
            "emptied" => bytes.clear(),
            _ => bytes = b"not a table at all".to_vec(),
        }
        std::fs::write(&part, &bytes).expect("a part");
        refused(&["train", &run], &["cell=000001/part-00000.parquet"]);
        assert_eq!(
            std::fs::read(&part).expect("a part"),
            bytes,
            "{damage}: rewritten"
        );
        assert!(!place.path("run/model").exists(), "{damage}: trained");
    }
    std::fs::write(&part, &whole).expect("a part");
    done(&["train", &run]);
}

/// A part of another run, and a stray file, in the dataset.
#[test]
fn foreign_part() {
    let (place, scene) = (Place::new(), cornell());
    let run = |name: &str, seed: &str| {
        let run = place.name(name);
        let extract = [&["extract", &scene, "-o", &run], &TINY[..]].concat();
        done(&[&extract[..], &["--seed", seed]].concat());
        run
    };
    let (one, _) = (run("one", "1"), run("two", "2"));
    let part = "samples/cell=000000/part-00000.parquet";
    std::fs::copy(place.path("two").join(part), place.path("one").join(part)).expect("a copy");
    refused(&["train", &one], &[part, "seed"]);

    let stray = place.path("two/samples/cell=000000/notes.txt");
    std::fs::write(&stray, "mine").expect("a file");
    refused(
        &["train", &place.name("two")],
        &["notes.txt", "Move it elsewhere"],
    );
    assert_eq!(std::fs::read(&stray).expect("still there"), b"mine");
}

/// Extracted but not trained, cells missing, no run at all.
#[test]
fn unfinished_run() {
    let (place, scene) = (Place::new(), cornell());
    let run = place.name("run");
    let extract = [&["extract", &scene, "-o", &run, "--cell", "0"], &TINY[..]].concat();
    done(&extract);
    refused(&["train", &run], &[&run, "cell 1", "rrf extract"]);
    let picture = place.name("a.exr");
    refused(
        &[&["render", &run, "-o", &picture], &LIGHT[..]].concat(),
        &["model", "No such file"],
    );

    let nothing = place.name("nothing");
    let words = [&nothing as &str, "not a run folder", "rrf bake"];
    refused(&["train", &nothing], &words);
    refused(&["render", &nothing, "-o", &picture], &words);
    refused(
        &[
            "query",
            &nothing,
            "--points",
            &oracle("cornell_free"),
            "-o",
            "a.parquet",
        ],
        &words,
    );
    assert!(!place.path("nothing").exists() && !place.path("a.exr").exists());
}

/// A net of another run, and a damaged one.
#[test]
fn damaged_model() {
    let (place, scene) = (Place::new(), cornell());
    let run = place.name("run");
    bake_tiny(&scene, &run, &[]);
    let weights = place.path("run/model/weights.arrow");
    let mut bytes = std::fs::read(&weights).expect("the weights");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 0x10;
    std::fs::write(&weights, &bytes).expect("the weights");
    let picture = place.name("a.exr");
    let render = [&["render", &run, "-o", &picture], &LIGHT[..]].concat();
    refused(&render, &["model/weights.arrow"]);
    assert!(!place.path("a.exr").exists());
}
