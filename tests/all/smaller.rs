//! A bake that has met its target gives nets no more weights than that takes.

use crate::program::{OVERHEAD, Place, cornell, done};

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
        done(&[&bake[..], &size, &["--target", "0.3"], more].concat())
    };
    let said = of(&small, &[]);
    assert!(said.out.contains("the target is reached"), "{said:#?}");
    of(&whole, &["--no-trim"]);
    let (small, whole) = (rounds(&small), rounds(&whole));
    assert_eq!((small.len(), whole.len()), (2, 1));
    assert_eq!(small[0], whole[0]);
    let (before, (error, se, weights)) = (small[0], small[1]);
    assert!(before.0 + before.1 < 0.25, "nothing to spare: {before:?}");
    assert!(error + se <= 0.3, "{error} ± {se}");
    assert!(weights < before.2 / 2, "{weights} of {} left", before.2);
}
