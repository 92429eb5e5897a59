//! What cannot be done says why, with exit code 2.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use std::process::{Command, Output};

fn call(arguments: &[&str]) -> Output {
    let program = env!("CARGO_BIN_EXE_rrf-report");
    Command::new(program).args(arguments).output().unwrap()
}

#[test]
fn bad_input_is_2_and_named() {
    let here = env!("CARGO_MANIFEST_DIR");
    let manifest = format!("{here}/Cargo.toml");
    for (arguments, named) in [
        (vec!["inspect", "no/such/place"], "no/such/place"),
        (vec!["inspect", &manifest], &manifest),
        (vec!["inspect", here], here),
        (vec!["chart", here, "-o", "never"], here),
        (vec!["chart", &manifest, "-o", "never"], &manifest),
        (
            vec!["sweep", "x.obj", "-o", "never", "--grid", &manifest],
            &manifest,
        ),
        (vec!["report", here, "-o", "never.html"], here),
    ] {
        if arguments[0] == "inspect" && !cfg!(feature = "inspect") {
            continue;
        }
        let output = call(&arguments);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        assert!(said.starts_with("rrf: ") && said.contains(named), "{said}");
        assert!(
            !said.contains("panicked") && output.stdout.is_empty(),
            "{said}"
        );
    }
    assert!(!std::path::Path::new("never").exists());
}

/// A full disk behind standard output is told, with exit code 1.
#[cfg(target_os = "linux")]
#[test]
fn a_full_output_is_told() {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    let table = format!("{root}/tests/data/oracle/cornell_overhead.parquet");
    if cfg!(feature = "inspect") {
        let full = std::fs::File::options().write(true).open("/dev/full");
        let output = Command::new(env!("CARGO_BIN_EXE_rrf-report"))
            .args(["inspect", &table])
            .stdout(full.unwrap())
            .output()
            .unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.contains("standard output cannot be written"), "{said}");
        assert!(!said.contains("panicked"), "{said}");
    }
}
