//! Bakes by what nets are compared with go through the same commands; what only nets can do is refused.

use crate::program::{OVERHEAD, Place, bytes_below, cornell, done, file, oracle, refused};

const TINY: [&str; 6] = ["--light-box", OVERHEAD, "--rows", "2000", "--paths", "4"];

#[test]
fn each_is_queried_and_rendered_and_has_the_same_bits_on_two_threads() {
    for method in METHODS {
        let place = Place::new();
        let bake = |name: &str, threads: &str| {
            let (scene, run) = (cornell(), place.name(name));
            let more = ["--method", method, "--threads", threads];
            done(&[&["bake", &scene, "-o", &run], &TINY[..], &more].concat());
            bytes_below(&place.path(name))
        };
        assert!(bake("one", "1") == bake("two", "2"), "{method}");
        let (run, out) = (place.name("one"), place.name("out.parquet"));
        let asked = oracle("cornell_overhead");
        done(&["query", &run, "--points", &asked, "-o", &out]);
        let frame = |light: &str, name: &str| {
            let view = ["--size", "16x16", "--light", light, "--part", "indirect"];
            done(&[&["render", &run, "-o", &place.name(name)], &view[..]].concat());
            std::fs::read(place.path(name)).expect("a frame")
        };
        let (one, other) = (frame("0,1.6,0", "a.exr"), frame("0.4,1.4,0.3", "b.exr"));
        assert!(one != other, "{method}: the light changes nothing");

        for format in ["--onnx", "--safetensors"] {
            let file = place.name("exported");
            refused(&["export", &run, format, &file], &["only nets"]);
            assert!(!place.path("exported").exists());
        }
    }
}

#[test]
fn what_only_nets_can_do_is_refused() {
    let (place, scene) = (Place::new(), cornell());
    for method in METHODS {
        let run = place.name("run");
        let bake = [
            "bake",
            &scene,
            "-o",
            &run,
            "--light-box",
            OVERHEAD,
            "--method",
            method,
        ];
        let with = |more: &[&'static str]| [&bake[..], more].concat();
        refused(&with(&["--rounds", "2"]), &["--rounds", "one round"]);
        refused(
            &with(&["--hidden", "8,4"]),
            &["--hidden", "no hidden units"],
        );
        if method != "quadratic-regression" {
            refused(
                &with(&["--cells", "3"]),
                &["--cells", "one cell for the whole"],
            );
        }
        assert!(place.holds(&[]));
        let made = place.name("made");
        let extract = ["extract", &scene, "-o", &made, "--method", method];
        done(&[&extract[..], &TINY[..]].concat());
        for mode in ["online", "recursive"] {
            refused(&["train", &made, "--mode", mode], &["of nets", "method is"]);
        }
        std::fs::remove_dir_all(place.path("made")).expect("the run");
    }
}

const METHODS: [&str; 3] = ["quadratic-regression", "nearest", "probes"];

/// Irradiance does not tell what a glossy surface shows.
#[test]
fn probes_of_glossy_scenes_are_refused() {
    let place = Place::new();
    let (scene, run) = (
        file("scenes/cornell-glossy/cornell-glossy.glb"),
        place.name("run"),
    );
    let words = ["--method probes", "need Lambertian surfaces"];
    refused(&["bake", &scene, "-o", &run, "--method", "probes"], &words);
    assert!(place.holds(&[]));
}
