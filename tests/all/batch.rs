//! `rrf run`: many bakes from one file.

use crate::program::{Place, bytes_below, cornell, done, refused, rrf, says};

const SETTINGS: &str = r#"
method = "nets"
light_box = [-0.6, 1.3, -0.6, 0.6, 1.8, 0.6]
rows = 2000
cells = 2
paths = 4
rounds = 1
"#;

fn batch(place: &Place, defaults: &str, bakes: &str) -> String {
    let text = format!("output = \"runs\"\n[defaults]\n{SETTINGS}{defaults}\n{bakes}");
    place.write("batch.toml", text)
}

fn bake(name: &str, scene: &str, settings: &str) -> String {
    format!("[[bake]]\nname = \"{name}\"\nscene = \"{scene}\"\n[bake.settings]\n{settings}\n")
}

/// Runs everything, then nothing, then only what another setting touches.
#[test]
fn only_what_changed() {
    let place = Place::new();
    let one = bake("one", &cornell(), "seeds = [1, 2]");
    let file = batch(&place, "", &one);
    done(&["run", &file, "--dry-run"]);
    assert!(!place.path("runs").exists(), "a dry run wrote something");
    done(&["-q", "run", &file]);
    let before = bytes_below(&place.path("runs/one-1"));
    assert!(place.path("runs/one-2/model/weights.arrow").exists());

    let written = |name: &str| {
        let meta = std::fs::metadata(place.path(name)).unwrap();
        meta.modified().unwrap()
    };
    let files = [
        "runs/one-1/model/weights.arrow",
        "runs/one-1/samples/cell=000000/part-00000.parquet",
    ];
    let times = files.map(written);
    done(&["-q", "run", &file]);
    assert_eq!(files.map(written), times, "an unchanged batch wrote again");
    assert!(bytes_below(&place.path("runs/one-1")) == before);

    // another target: judged anew, nothing extracted or fitted
    let fit = "runs/one-1/rounds/000/fits/cell=000000/weights.arrow";
    let fitted = written(fit);
    done(&["-q", "run", &batch(&place, "target = 0.9", &one)]);
    assert_eq!((written(files[1]), written(fit)), (times[1], fitted));
    let judged = std::fs::read_to_string(place.path("runs/one-1/rounds/000/judged.json")).unwrap();
    assert!(judged.contains("\"target\""), "{judged}");

    // other samples: as if baked so from the beginning
    let more = bake("one", &cornell(), "seeds = [1, 2]\nrows = 3000");
    done(&["-q", "run", &batch(&place, "", &more)]);
    let fresh = Place::new();
    done(&["-q", "run", &batch(&fresh, "", &more)]);
    let (changed, fresh) = (place.path("runs/one-1"), fresh.path("runs/one-1"));
    assert!(bytes_below(&changed) == bytes_below(&fresh));
}

/// A scene that was edited is baked as if it had been so from the beginning, its test rows too.
#[test]
fn an_edited_scene_is_baked_anew() {
    let text = std::fs::read_to_string(cornell()).unwrap();
    let edited = text.replacen("0.63", "0.61", 1);
    assert_ne!(text, edited);
    let place = Place::new();
    let scene = place.write("room.pbrt", text);
    let file = batch(&place, "", &bake("one", &scene, "rows = 3000"));
    done(&["-q", "run", &file]);
    place.write("room.pbrt", edited);
    // fewer rows: no part of the earlier bake may be left over
    let file = batch(&place, "", &bake("one", &scene, ""));
    done(&["-q", "run", &file]);
    let changed = bytes_below(&place.path("runs/one-1"));
    std::fs::remove_dir_all(place.path("runs/one-1")).unwrap();
    done(&["-q", "run", &file]);
    assert!(changed == bytes_below(&place.path("runs/one-1")));
}

/// Every fault is named, and nothing begins.
#[test]
fn faults_before_anything_starts() {
    let place = Place::new();
    let scene = cornell();
    let bakes = [
        bake("fine", &scene, ""),
        bake("fine", &scene, ""),
        bake("no-scene", "missing.pbrt", ""),
        bake("outside", &scene, "light_box = [5, 5, 5, 6, 6, 6]"),
        bake("eyes", &scene, "eye_box = [7, 7, 7, 8, 8, 8]"),
        bake("preset", &scene, "preset = \"best\""),
        bake("method", &scene, "method = \"guess\""),
    ];
    let file = batch(&place, "", &bakes.concat());
    let words = [
        "fine: the name is there twice",
        "missing.pbrt",
        "outside the scene",
        "eye box 7,7,7,8,8,8",
        "'best'",
        "transfer, nets, linear-outputs",
    ];
    refused(&["run", &file], &words);
    let file = batch(&place, "colour = 1", &bakes[0]);
    refused(&["run", &file], &["batch.toml", "colour"]);
    refused(
        &["run", &place.name("none.toml")],
        &["none.toml", "cannot read"],
    );
    assert!(!place.path("runs").exists());
}

/// A method of the file is that of the command line.
#[test]
fn methods() {
    let place = Place::new();
    let one = bake("one", &cornell(), "method = \"linear-regression\"");
    done(&["-q", "run", &batch(&place, "", &one)]);
    let run = place.name("run");
    let text = "-q bake --light-box=-0.6,1.3,-0.6,0.6,1.8,0.6 --rows 2000 --cells 2 --paths 4";
    let mut words: Vec<&str> = text.split(' ').collect();
    let scene = cornell();
    words.extend(["--method", "linear-regression", &scene, "-o", &run]);
    done(&words);
    assert!(bytes_below(&place.path("runs/one-1")) == bytes_below(&place.path("run")));
}

/// A second run beside the first ends with 1 and touches nothing.
#[test]
fn one_at_a_time() {
    let place = Place::new();
    let file = batch(&place, "", &bake("one", &cornell(), ""));
    std::fs::create_dir(place.path("runs")).unwrap();
    let lock = std::fs::File::create(place.path("runs/lock")).unwrap();
    lock.lock().unwrap();
    let said = rrf(&["run", &file]);
    assert_eq!(said.code, Some(1), "{said:#?}");
    says(&said, &["runs: in use by another process"]);
    assert!(!place.path("runs/one-1").exists());
    drop(lock);
    done(&["-q", "run", &file]);
}
