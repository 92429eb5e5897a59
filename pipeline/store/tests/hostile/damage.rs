//! Good files, damaged everywhere.

use crate::{foreign, frugally, made};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::{Index, select};
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use rrf_store::Limits;
use rrf_store::StoreError;
use rrf_store::layout::{fit_folder, part_path};
use rrf_store::manifest::RunManifest;
use rrf_store::model::{
    read_metrics, read_steps, read_tree, read_weights, write_metrics, write_steps, write_tree,
    write_weights,
};
use rrf_store::parts::{read_part, write_part};
use rrf_store::points::read_points;
use std::io::Write;
use std::path::{Path, PathBuf};

/// One kind of file: a good one, and whether what is read from it is right.
struct Kind {
    name: String,
    path: PathBuf,
    /// `Ok(true)`: read, and the same values as before the damage.
    read: Box<dyn Fn() -> Result<bool, StoreError>>,
    /// Whether damage to values must be found.
    hashed: bool,
}

fn kinds(run: &Path) -> Vec<Kind> {
    let facts = made::facts();
    write_part(run, 0, &made::samples(1, 0, 40), &facts).unwrap();
    write_tree(run, &made::tree(), &facts).unwrap();
    let models = [0, 1, 2].map(made::cell_model);
    write_weights(run, &models, &facts).unwrap();
    let metrics = [0, 1, 2].map(made::metrics);
    write_metrics(run, &metrics, &facts).unwrap();
    let fit = fit_folder(run, 0, 1);
    write_steps(&fit, &made::steps(), &facts).unwrap();
    let kind = |name: &str, path: PathBuf, read: Box<dyn Fn() -> Result<bool, StoreError>>| Kind {
        name: name.into(),
        path,
        read,
        hashed: true,
    };
    let run = run.to_path_buf();
    let [a, b, c, d, e] = [(); 5].map(|()| (run.clone(), facts.clone()));
    let model = |name: &str| run.join(format!("model/{name}.arrow"));
    let mut kinds = vec![
        kind(
            "part",
            part_path(&run, 1, 0),
            Box::new(move || Ok(read_part(&a.0, 1, 0, &a.1)? == made::samples(1, 0, 40))),
        ),
        kind(
            "tree",
            model("tree"),
            Box::new(move || Ok(read_tree(&b.0, &b.1)? == made::tree())),
        ),
        kind(
            "weights",
            model("weights"),
            Box::new(move || Ok(read_weights(&c.0, &c.1)? == models)),
        ),
        kind(
            "metrics",
            model("metrics"),
            Box::new(move || Ok(read_metrics(&d.0, &d.1)? == metrics)),
        ),
        kind(
            "steps",
            fit.join("steps.arrow"),
            Box::new(move || Ok(read_steps(&fit, &e.1)? == Some(made::steps()))),
        ),
    ];
    for (name, bytes) in foreign::tables() {
        let path = run.join(&name);
        std::fs::write(&path, bytes).unwrap();
        let read_path = path.clone();
        kinds.push(Kind {
            name,
            path,
            read: Box::new(move || read_points(&read_path, Limits::default()).map(|_| true)),
            hashed: false,
        });
    }
    kinds
}

/// Overwrites a file in place: an emptied and rewritten one makes some file systems sync.
fn put(path: &Path, bytes: &[u8]) {
    let mut file = std::fs::OpenOptions::new().write(true).open(path).unwrap();
    file.write_all(bytes).unwrap();
    file.set_len(bytes.len() as u64).unwrap();
}

/// Reads a damaged file; values must be refused or right.
fn check(kind: &Kind, what: &str, bytes: &[u8]) {
    put(&kind.path, bytes);
    match frugally(what, &kind.read) {
        Ok(right) => assert!(right || !kind.hashed, "{}: {what}: wrong values", kind.name),
        Err(error) => {
            let place = kind.path.display().to_string();
            assert!(error.to_string().starts_with(&place), "{what}: {error}");
            assert!(error.is_bad_input(), "{what}: {error}");
        }
    }
}

/// The decoders' panics are caught; their reports would fill the log.
fn quiet() {
    std::panic::set_hook(Box::new(|info| {
        let inside = info
            .location()
            .is_some_and(|at| at.file().contains("tests/hostile"));
        if inside {
            eprintln!("{info}");
        }
    }));
}

#[test]
fn cut_off_anywhere() {
    quiet();
    let run = tempfile::tempdir().unwrap();
    for kind in kinds(run.path()) {
        let good = std::fs::read(&kind.path).unwrap();
        assert!((kind.read)().unwrap(), "{}: the good file", kind.name);
        for length in (0..good.len()).step_by(7) {
            put(&kind.path, &good[..length]);
            let read = frugally(&kind.name, &kind.read);
            assert!(
                matches!(read, Err(StoreError::Corrupt { .. })),
                "{} {length}",
                kind.name
            );
        }
        put(&kind.path, &good);
    }
}

#[test]
fn one_byte_changed_anywhere() {
    quiet();
    let run = tempfile::tempdir().unwrap();
    for kind in kinds(run.path()) {
        let good = std::fs::read(&kind.path).unwrap();
        let mut bytes = good.clone();
        // Ours everywhere, the many foreign ones at every third place.
        for at in (0..good.len()).step_by(if kind.hashed { 1 } else { 3 }) {
            // Another bit each byte, so that high and low ones are met everywhere.
            bytes[at] ^= 1 << (at % 8);
            check(&kind, &format!("byte {at}"), &bytes);
            bytes[at] = good[at];
        }
        put(&kind.path, &good);
    }
}

/// Proptest's runner with a fixed source of randomness; RRF_DAMAGE multiplies the cases.
fn runner(cases: u32) -> TestRunner {
    let more = std::env::var("RRF_DAMAGE").ok();
    let config = Config {
        cases: cases * more.and_then(|more| more.parse().ok()).unwrap_or(1),
        failure_persistence: None,
        ..Config::default()
    };
    TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha))
}

/// Several changes at once, many to values that hurt as lengths, counts and offsets.
#[test]
fn many_changes() {
    quiet();
    let run = tempfile::tempdir().unwrap();
    let hurtful: [&[u8]; 7] = [
        &[0xff, 0xff, 0xff, 0x7f],
        &[0; 8],
        &[0xff; 8],
        &[0x80; 9],
        &[0, 0, 0, 0, 0, 0, 0, 0x40],
        &[1],
        &[0x7f],
    ];
    let hurtful = select(hurtful.map(<[u8]>::to_vec).to_vec());
    let change = (any::<Index>(), prop_oneof![hurtful, vec(any::<u8>(), 1..4)]);
    for kind in kinds(run.path()) {
        let good = std::fs::read(&kind.path).unwrap();
        runner(500)
            .run(&vec(change.clone(), 1..6), |changes| {
                let mut bytes = good.clone();
                for (at, with) in &changes {
                    let at = at.index(bytes.len());
                    let end = (at + with.len()).min(bytes.len());
                    bytes[at..end].copy_from_slice(&with[..end - at]);
                }
                check(&kind, &format!("{changes:?}"), &bytes);
                Ok(())
            })
            .unwrap();
        put(&kind.path, &good);
    }
}

/// Bytes that are no file at all, with the marks of one.
#[test]
fn anything_between_the_marks() {
    quiet();
    let run = tempfile::tempdir().unwrap();
    for kind in kinds(run.path()) {
        let parquet = kind.path.extension().is_some_and(|e| e == "parquet");
        let (head, tail): (&[u8], &[u8]) = match parquet {
            true => (b"PAR1", b"PAR1"),
            false => (b"ARROW1\0\0", b"ARROW1"),
        };
        let bytes = (vec(any::<u8>(), 0..400), 0u32..500);
        runner(500)
            .run(&bytes, |(middle, length)| {
                let bytes = [head, &middle, &length.to_le_bytes(), tail].concat();
                put(&kind.path, &bytes);
                prop_assert!(frugally("marks", &kind.read).is_err());
                Ok(())
            })
            .unwrap();
    }
}

#[test]
fn any_manifest() {
    let run = tempfile::tempdir().unwrap();
    let path = RunManifest::path(run.path());
    std::fs::write(&path, "").unwrap();
    runner(500)
        .run(&".{0,200}", |text| {
            put(&path, text.as_bytes());
            prop_assert!(RunManifest::read(run.path()).is_err());
            Ok(())
        })
        .unwrap();
}
