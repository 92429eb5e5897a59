//! Frames in bulk, what a frame costs, and views and lights that make no sense.

use crate::program::{Place, cornell, done, refused, text, tiny_run};
use std::path::Path;

const HEAD: &str = "eye_x,eye_y,eye_z,target_x,target_y,target_z,fov";
const ROW: &str = "0,1,3.5,0,1,0,40";

fn bytes(path: &Path) -> Vec<u8> {
    std::fs::read(path).expect("a frame")
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("the frames");
    let mut names: Vec<String> = entries
        .map(|entry| text(Path::new(&entry.expect("an entry").file_name())))
        .collect();
    names.sort();
    names
}

/// One frame a row; rows that are equal give equal bytes, indirect part and all; and each frame
/// is the one that the same options give alone.
#[test]
fn a_path_of_frames() {
    let (place, run) = (Place::new(), tiny_run());
    let light = "0.1,1.5,0.2,2,2,2";
    let columns = "light0_x,light0_y,light0_z,light0_r,light0_g,light0_b";
    let rows = [
        format!("{HEAD},{columns}"),
        format!("{ROW},{light}"),
        format!("0.1,1,3.5,0,1,0,40,{light}"),
        format!("{ROW},{light}"),
    ];
    let camera = place.write("camera.csv", rows.join("\n"));
    let frames = place.name("frames");
    done(&[
        "render", &run, "--path", &camera, "-o", &frames, "--size", "48x32",
    ]);
    let folder = place.path("frames");
    let numbered = (0..3).flat_map(|k| ["exr", "png"].map(|e| format!("frame-{k:05}.{e}")));
    let mut expected: Vec<String> = numbered.collect();
    expected.insert(0, "contact-sheet.png".to_string());
    assert_eq!(names(&folder), expected);
    for ending in ["exr", "png"] {
        let frame = |k: u32| bytes(&folder.join(format!("frame-{k:05}.{ending}")));
        assert!(frame(0) == frame(2), "{ending}: equal rows, unequal frames");
        assert!(frame(0) != frame(1), "{ending}: unequal rows, equal frames");
    }
    let alone = place.name("alone.exr");
    let view = ["--eye", "0,1,3.5", "--look-at", "0,1,0", "--fov", "40"];
    let light = ["--light", light, "--size", "48x32", "-o", &alone];
    done(&[&["render", &run], &view[..], &light[..]].concat());
    let compared = done(&["compare", &alone, &text(&folder.join("frame-00000.exr"))]);
    let says_equal = |line: &str| {
        line.split_whitespace()
            .take(2)
            .eq(["relative_error", "0.00000"])
    };
    assert!(compared.out.lines().any(says_equal), "{compared:?}");

    // frames of another path are not mixed with these
    refused(
        &["render", &run, "--path", &camera, "-o", &frames],
        &[&frames, "not empty"],
    );
}

#[test]
fn paths_that_cannot_be_followed() {
    let (place, run) = (Place::new(), tiny_run());
    let cases = [
        (format!("{HEAD}\n{ROW}\n0,nan,3,0,1,0,40"), "row 2: eye_y"),
        (
            format!("{HEAD}\n{ROW}\n{ROW}\n0,1,3,0,1,3,40"),
            "row 3: the view",
        ),
        (format!("{HEAD}\n0,1,3,0,1"), "row 1: 5 values"),
        (HEAD.to_string(), "no row"),
        ("eye_x,eye_y,fov\n0,0,1".to_string(), "no column eye_z"),
        // the tall box
        (
            format!("{HEAD}\n{ROW}\n-0.33,0.6,-0.3,0,1,0,40"),
            "row 2: the eye",
        ),
    ];
    for (csv, words) in cases {
        let camera = place.write("camera.csv", csv);
        let frames = place.name("frames");
        let call = [
            "render", &run, "--path", &camera, "-o", &frames, "--light", "0,1.5,0",
        ];
        refused(&call, &[&camera, words]);
        assert!(
            !place.path("frames").exists(),
            "{words}: something was written"
        );
    }
    let none = place.name("none.csv");
    refused(
        &[
            "render", &run, "--path", &none, "-o", "frames", "--light", "0,1.5,0",
        ],
        &[&none, "No such file"],
    );
}

/// An eye inside a box, a light inside one, a light on the floor: refused, unless asked again.
#[test]
fn views_and_lights_in_matter() {
    let (place, run) = (Place::new(), tiny_run());
    let out = place.name("a.png");
    let call =
        |more: &[&'static str]| [&["render", &run, "--size", "16x16", "-o", &out], more].concat();
    let inside = "-0.33,0.6,-0.3";
    let eye = ["--eye", inside, "--look-at", "0,1,0", "--light", "0,1.5,0"];
    let cases: [(&[&'static str], &str); 3] = [
        (&eye, "the eye at"),
        (
            &["--light", inside],
            "light 0 at -0.33,0.6,-0.3 is inside a solid",
        ),
        (
            &["--light", "0,1.5,0", "--light", "0.8,0,0.8"],
            "light 1 at 0.8,0,0.8 lies on",
        ),
    ];
    for (more, words) in cases {
        refused(&call(more), &[words, "--anyway"]);
        assert!(!place.path("a.png").exists());
        let said = done(&[&call(more)[..], &["--anyway"]].concat());
        assert!(said.err.contains(words), "{said:?}");
        std::fs::remove_file(place.path("a.png")).expect("the picture");
    }
}

/// The stages' times are there, add up to the processor's, and the pixels are the same.
#[test]
fn what_a_frame_costs() {
    let (place, run) = (Place::new(), tiny_run());
    let (stats, out) = (place.name("stats.json"), place.name("a.png"));
    let light = ["--light", "0,1.5,0", "--size", "64x64", "-o", &out];
    let measure = ["--frames", "3", "--json-stats", &stats];
    done(&[&["render", &run], &light[..], &measure[..]].concat());
    let measured = bytes(&place.path("a.png"));
    done(&[&["render", &run], &light[..]].concat());
    assert!(measured == bytes(&place.path("a.png")));

    let text = std::fs::read_to_string(&stats).expect("the stats");
    let stats: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(
        (&stats["frames"], &stats["point_lights"]),
        (&3.into(), &1.into())
    );
    let stages = stats["stages"].as_array().expect("stages");
    let names: Vec<&str> = stages.iter().filter_map(|s| s["stage"].as_str()).collect();
    let expected = [
        "primary_rays",
        "points",
        "direct",
        "shadow_rays",
        "cell_lookup",
        "inputs",
        "nets",
        "resolve",
    ];
    assert_eq!(names, expected);
    assert!(
        stages
            .iter()
            .all(|s| s["processor_ms"].as_f64() > Some(0.0)),
        "{text}"
    );
    refused(
        &[&["render", &run, "--frames", "3"], &light[..]].concat(),
        &["--json-stats"],
    );
}

/// Lamps shine in a model's frame, as in a traced one: direct light is the same within its
/// noise, and what stands for the lamp in the nets is said.
#[test]
fn the_scenes_own_lamp() {
    let (place, run) = (Place::new(), tiny_run());
    let (model, traced) = (place.name("m.exr"), place.name("t.exr"));
    let said = done(&[
        "render",
        &run,
        "--size",
        "32x32",
        "--shadow-rays",
        "256",
        "-o",
        &model,
    ]);
    assert!(
        said.err.contains("area light 0: the nets light it as"),
        "{said:?}"
    );
    let scene = cornell();
    done(&[
        "trace", &scene, "-q", "--size", "32x32", "--spp", "256", "-o", &traced,
    ]);
    let compared = done(&["compare", &model, &traced, "--layer", "direct", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&compared.out).expect("JSON");
    let mean = |name: &str| json[name].as_f64().expect("a luminance");
    // 1,024 pixels of 256 rays: their mean's noise is a few thousandths
    let ratio = mean("test_luminance") / mean("reference_luminance");
    assert!((ratio - 1.0).abs() < 0.02, "{ratio}");
}
