//! From a scene file to a frame.

use crate::judge::Oracle;
use crate::program::{OVERHEAD, Place, cornell, done, oracle};
use crate::table::Table;

/// Bake, query, render, trace, compare: a preview of the Cornell box is near the oracle's
/// points and near the path-traced frame; frames that are wrong are not.
#[test]
fn scene_to_frame() {
    let (place, scene) = (Place::new(), cornell());
    let run = place.name("run");
    let bake = ["bake", &scene, "-o", &run, "--light-box", OVERHEAD];
    let nets = ["--method", "nets", "--preset", "preview"];
    let said = done(&[&bake[..], &nets].concat());
    assert!(
        said.out.contains("relative error on held-out rows"),
        "{said:#?}"
    );
    assert!(said.out.contains("points that see nothing"), "{said:#?}");

    let (input, answers) = (oracle("cornell_overhead"), place.name("answers.parquet"));
    done(&["query", &run, "--points", &input, "-o", &answers]);
    let answers = Table::read(&answers);
    let (error, error_se) = Oracle::read(&input).relative_error(&answers.rgb(""));
    assert!(error < 0.15, "relative error {error:.4} ± {error_se:.4}");
    assert!(answers.has("cell_id") && answers.has("trusted"));

    // a preview's cells err by some percent each: good enough at first, not all of them for a limit of five
    let trusted = |limit: &str| {
        let more = place.name("more.parquet");
        done(&[
            "query",
            &run,
            "--points",
            &input,
            "-o",
            &more,
            "--trust-error",
            limit,
        ]);
        let rows = Table::read(&more).numbers("trusted");
        rows.iter().sum::<f64>() / rows.len() as f64
    };
    assert!(trusted("0.5") > 0.9);
    assert!(trusted("0.05") < 0.9);

    // neighbours that agree are blended near their borders, a few rows by a few percent
    let more = place.name("blended.parquet");
    done(&["query", &run, "--points", &input, "-o", &more, "--blend"]);
    let blended = Table::read(&more).rgb("");
    let own = answers.rgb("");
    let changed = own.iter().zip(&blended).filter(|(a, b)| a != b).count();
    assert!(changed > 0 && changed < own.len() / 2, "{changed}");
    let (error, error_se) = Oracle::read(&input).relative_error(&blended);
    assert!(error < 0.15, "relative error {error:.4} ± {error_se:.4}");

    frames(&place, &scene, &run);
}

/// The limits of a frame: root mean square ΔE*ab of at most 5, where leaving the indirect light
/// out, or putting the lamp on the other side, costs more than twice as much.
fn frames(place: &Place, scene: &str, run: &str) {
    let size = ["--size", "128x128"];
    let light = ["--light", "0.1,1.6,0.2,4,4,4"];
    let frame = |name: &str, call: &[&str], more: &[&[&str]]| {
        let out = place.name(name);
        done(&[call, &["-o", &out], &size, &more.concat()].concat());
        out
    };
    let traced = frame("traced.exr", &["trace", scene, "--spp", "256"], &[&light]);
    let model = frame("model.exr", &["render", run], &[&light]);
    let direct = frame(
        "direct.exr",
        &["render", run],
        &[&light, &["--part", "direct"]],
    );
    let moved = frame(
        "moved.exr",
        &["render", run],
        &[&["--light", "-0.3,1.6,0.2,4,4,4"]],
    );
    let blended = frame("blended.exr", &["render", run, "--blend"], &[&light]);

    // where nets are not good enough paths are
    let better = frame(
        "better.exr",
        &[
            "render",
            run,
            "--fallback",
            "trace",
            "--trust-error",
            "0.001",
        ],
        &[&light],
    );

    // the grain of lamps that are sampled belongs to the seed
    let seeded = |name: &str, seed: &str| {
        let lamps = ["--scene-lights", "--seed", seed];
        std::fs::read(frame(name, &["render", run], &[&lamps])).expect("the frame")
    };
    let first = seeded("seed1.exr", "1");
    assert!(first == seeded("again1.exr", "1"));
    assert!(first != seeded("seed2.exr", "2"));

    let picture = place.name("model.png");
    done(&[&["render", run, "-o", &picture], &size[..], &light].concat());
    let png = std::fs::read(&picture).expect("the picture");
    assert_eq!(&png[1..4], b"PNG");

    for layer in ["full", "indirect", "direct"] {
        let measures = compare(&model, &traced, layer);
        assert!(
            measures.iter().all(|(_, x)| x.is_finite()),
            "{layer}: {measures:?}"
        );
    }
    let delta_e = |frame: &str| measure(&compare(frame, &traced, "full"), "delta_e_ab");
    assert!(delta_e(&model) < 5.0, "{}", delta_e(&model));
    assert!(delta_e(&direct) > 10.0, "{}", delta_e(&direct));
    assert!(delta_e(&moved) > 10.0, "{}", delta_e(&moved));
    assert!(delta_e(&blended) < 5.0, "{}", delta_e(&blended));
    assert_ne!(delta_e(&blended), delta_e(&model));
    assert!(delta_e(&better) < delta_e(&model), "{}", delta_e(&better));
    assert_eq!(delta_e(&traced), 0.0);
}

fn compare(a: &str, b: &str, layer: &str) -> Vec<(String, f64)> {
    let said = done(&["compare", a, b, "--json", "--layer", layer]);
    let found: serde_json::Value = serde_json::from_str(&said.out).expect("JSON");
    assert_eq!(
        (&found["width"], &found["height"]),
        (&128.into(), &128.into())
    );
    let measures = found["measures"].as_array().expect("measures");
    let pair = |m: &serde_json::Value| {
        assert!(!m["definition"].as_str().expect("a definition").is_empty());
        let name = m["name"].as_str().expect("a name").to_string();
        (name, m["value"].as_f64().expect("a number"))
    };
    measures.iter().map(pair).collect()
}

fn measure(measures: &[(String, f64)], name: &str) -> f64 {
    let found = measures.iter().find(|(n, _)| n == name);
    found
        .unwrap_or_else(|| panic!("no {name} in {measures:?}"))
        .1
}
