//! Calls that make no sense: exit code 2, what was wrong, and nothing is written.

use crate::program::{Place, Said, cornell, done, oracle, refused, rrf, tiny_run};

/// A call with `-o` into an empty folder is refused, and the folder stays empty.
fn refused_with_output(call: &[&str], output: &str, words: &[&str]) -> Said {
    let place = Place::new();
    let out = place.name(output);
    let said = refused(&[call, &["-o", &out]].concat(), words);
    assert!(place.holds(&[]), "{call:?}: something was written");
    said
}

#[test]
fn unknown_words() {
    refused(&["bkae"], &["bkae", "--help"]);
    refused(
        &["bake", &cornell(), "--lite-box", "1"],
        &["--lite-box", "--help"],
    );
    refused(&["bake"], &["SCENE"]);
    // the list of all commands: no message, and as long as it is
    let list = rrf(&[]);
    assert_eq!(list.code, Some(2));
    assert!(
        list.err.contains("Usage") && list.err.contains("bake"),
        "{list:#?}"
    );
    refused(
        &["bake", &cornell(), "-o", "x", "--preset", "best"],
        &["best", "preview"],
    );
}

#[test]
fn numbers_out_of_range() {
    let scene = cornell();
    let trace = |more: &[&str], words: &[&str]| {
        refused_with_output(&[&["trace", &scene], more].concat(), "a.exr", words);
    };
    let light = ["--light", "0,1,0"];
    trace(&["--size", "0x8"], &["0x8", "1 to 16384"]);
    trace(&["--size", "8"], &["WIDTHxHEIGHT"]);
    trace(&["--light", "0,1"], &["0,1"]);
    trace(&["--light", "0,1,0,-1,1,1"], &["negative"]);
    trace(&["--light", "0,nan,0"], &["nan", "finite"]);
    trace(&["--fov", "0"], &["--fov", "above 0"]);
    trace(
        &[&light[..], &["--fov", "180"]].concat(),
        &["--fov 180", "0 and 180"],
    );
    trace(&[&light[..], &["--spp", "0"]].concat(), &["0 paths"]);
    trace(
        &[&light[..], &["--spp", "16", "--aa", "3"]].concat(),
        &["16 paths", "multiple of 18"],
    );
    trace(&["--eye", "0,1,0"], &["--look-at"]);
    trace(&["--eye", "0,1,0", "--look-at", "0,1,0"], &["no direction"]);
    trace(&["--threads", "0"], &["--threads", "1..=1024"]);
    let bake = ["bake", &scene, "--light-box", "1,1,1,0,0,0"];
    refused_with_output(&bake, "run", &["--light-box", "smaller"]);
}

#[test]
fn points_need_a_multiple() {
    let (scene, input) = (cornell(), oracle("cornell_free"));
    for paths in ["0", "100"] {
        let call = ["trace", &scene, "--points", &input, "--spp", paths];
        refused_with_output(&call, "a.parquet", &["--spp", paths, "multiple of 16"]);
    }
}

#[test]
fn unknown_picture_ending() {
    let (scene, run) = (cornell(), tiny_run());
    for ending in ["a.jpg", "a", "a.exr.bak"] {
        let words = [ending, "unknown picture format", ".exr", ".png"];
        refused_with_output(&["trace", &scene, "--light", "0,1,0"], ending, &words);
        refused_with_output(&["render", &run, "--light", "0,1,0"], ending, &words);
    }
}

#[test]
fn frames_that_do_not_compare() {
    let (place, run) = (Place::new(), tiny_run());
    let frame = |name: &str, size: &str| {
        let out = place.name(name);
        let light = ["--light", "0,1.6,0", "--size", size];
        done(&[&["render", &run, "-o", &out], &light[..]].concat());
        out
    };
    let (a, b) = (frame("a.exr", "16x16"), frame("b.exr", "16x8"));
    refused(&["compare", &a, &b], &["16", "8"]);
    refused(
        &["compare", &a, &place.name("no.exr")],
        &["no.exr", "No such file"],
    );
    refused(
        &["compare", &a, &a, "--layer", "depth"],
        &["a.exr", "depth", "direct"],
    );
    let text = place.write("c.exr", "no picture");
    refused(&["compare", &a, &text], &["c.exr"]);
}

/// Only a person's mistakes are bad input: help and version are not.
#[test]
fn help_ends_well() {
    for call in [
        &["--help"][..],
        &["bake", "--help"],
        &["--version"],
        &["doctor"],
    ] {
        assert_eq!(rrf(call).code, Some(0), "{call:?}");
    }
}
