//! `run.json`.

use crate::made;
use rrf_store::StoreError;
use rrf_store::manifest::{RunFacts, RunManifest};

#[test]
fn read_back_as_written() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("deep/er/run");
    made::manifest().write(&run).unwrap();
    assert_eq!(RunManifest::read(&run).unwrap(), made::manifest());
    let bytes = std::fs::read(run.join("run.json")).unwrap();
    made::manifest().write(&run).unwrap();
    assert_eq!(bytes, std::fs::read(run.join("run.json")).unwrap());
    // A seed beyond 2^53 keeps its last digit.
    assert!(
        String::from_utf8(bytes)
            .unwrap()
            .contains("18446744073709551614")
    );
}

#[test]
fn no_run_and_another_run() {
    let run = tempfile::tempdir().unwrap();
    let error = RunManifest::read(run.path()).unwrap_err();
    assert!(matches!(error, StoreError::NotARun { .. }), "{error}");
    made::manifest().write(run.path()).unwrap();
    let other = RunFacts {
        scene_hash: "e".repeat(64),
        ..made::facts()
    };
    let error = made::manifest().expect(run.path(), &other).unwrap_err();
    assert!(matches!(
        error,
        StoreError::Foreign {
            fact: "scene hash",
            ..
        }
    ));
    assert!(made::manifest().expect(run.path(), &made::facts()).is_ok());
}

#[test]
fn unreadable_manifests_say_why() {
    let run = tempfile::tempdir().unwrap();
    made::manifest().write(run.path()).unwrap();
    let path = run.path().join("run.json");
    let good = std::fs::read_to_string(&path).unwrap();
    let cases = [
        (
            good.replace("\"format\": 1", "\"format\": 99"),
            "of version 99",
        ),
        (good.replace("\"format\"", "\"forma\""), "of version null"),
        (good.replace("\"seed\"", "\"sead\""), "unknown field `sead`"),
        (good.replace("0123", "xyz"), "64 hexadecimal"),
        (good.replace("1.3", "1e99"), "no box"),
        (good.replace("1.3", "9.5"), "no box"),
        (good[..good.len() / 2].to_string(), "EOF"),
        ("[".repeat(100_000), "recursion limit"),
        (String::new(), "EOF"),
    ];
    for (text, wanted) in cases {
        std::fs::write(&path, &text).unwrap();
        let error = RunManifest::read(run.path()).unwrap_err();
        assert!(error.to_string().contains(wanted), "{wanted}: {error}");
        assert!(error.is_bad_input());
    }
    let mut manifest = made::manifest();
    manifest.light_box[0] = f32::NAN;
    assert!(manifest.write(run.path()).is_err());
}
