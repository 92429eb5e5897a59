//! A bake that has met its target gives nets no more weights than that takes.

use crate::program::{OVERHEAD, Place, cornell, done};
use std::path::PathBuf;

/// Error, its standard error and the weights of all nets after each round.
fn rounds(run: &str) -> Vec<(f64, f64, u64)> {
    let judged = (0..).map_while(|round| {
        let path = format!("{run}/rounds/{round:03}/judged.json");
        let text = std::fs::read_to_string(path).ok()?;
        let found: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        Some(found["judgement"].clone())
    });
    let number = |x: &serde_json::Value| x.as_f64().expect("a number");
    let of = |judged: serde_json::Value| {
        let cells = judged["cells"].as_array().expect("cells");
        let weights = cells.iter().filter_map(|c| c["weights"].as_u64()).sum();
        let (error, se) = (&judged["relative_error"], &judged["relative_error_se"]);
        (number(error), number(se), weights)
    };
    judged.map(of).collect()
}

/// A target far above what the first round reaches: half of the weights go, the target is still met,
/// and the fits say which inputs went. Without trimming, the first round is the model.
#[test]
fn nets_lose_what_the_target_can_spare() {
    let (place, scene) = (Place::new(), cornell());
    let (small, whole) = (place.name("small"), place.name("whole"));
    let of = |run: &str, more: &[&str]| {
        let bake = ["bake", &scene, "-o", run, "--light-box", OVERHEAD];
        let size = ["--rows", "16000", "--cells", "4", "--paths", "64"];
        let bake = [&bake[..], &["--method", "nets"]].concat();
        done(&[&bake[..], &size, &["--target", "0.35"], more].concat())
    };
    let said = of(&small, &[]);
    assert!(said.out.contains("the target is reached"), "{said:#?}");
    of(&whole, &["--no-trim"]);
    let (trimmed, whole) = (rounds(&small), rounds(&whole));
    assert_eq!((trimmed.len(), whole.len()), (2, 1));
    assert_eq!(trimmed[0], whole[0]);
    let (before, (error, se, weights)) = (trimmed[0], trimmed[1]);
    assert!(before.0 + before.1 < 0.3, "nothing to spare: {before:?}");
    assert!(error + se <= 0.35, "{error} ± {se}");
    assert!(weights < before.2 / 2, "{weights} of {} left", before.2);

    // cut off by a time limit before the last of its fits, the round keeps those that are done
    for gone in ["judged.json", "fits/cell=000001"] {
        let path = PathBuf::from(format!("{small}/rounds/001/{gone}"));
        let removed = match path.is_dir() {
            true => std::fs::remove_dir_all(&path),
            false => std::fs::remove_file(&path),
        };
        removed.expect("a file of the round");
    }
    of(&small, &["--resume", "--time-limit", "0.001"]);
    let cut_off = rounds(&small);
    assert_eq!((cut_off.len(), cut_off[0]), (2, trimmed[0]));
    let (left, all) = (cut_off[1].2, trimmed[0].2);
    assert!(weights < left && left < all, "{weights} < {left} < {all}");
    assert!(cut_off[1].0 + cut_off[1].1 <= 0.35, "{:?}", cut_off[1]);
}
