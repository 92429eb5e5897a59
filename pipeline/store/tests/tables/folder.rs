//! Folders that cannot be written, and writers that are interrupted.

use crate::made;
use rrf_store::StoreError;
use rrf_store::atomic::{atomic_write, create_folder};
use rrf_store::layout::{remove_unfinished, samples_folder, staging_folder};
use rrf_store::parts::write_part;
use std::path::Path;
use std::process::Command;

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = entries
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn replaced_whole_and_nothing_left_over() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.bin");
    atomic_write(&path, b"one").unwrap();
    // Left by a killed writer.
    std::fs::write(folder.path().join(".a.bin.0.tmp"), b"tor").unwrap();
    atomic_write(&path, b"two").unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), b"two");
    assert_eq!(names(folder.path()), [".a.bin.0.tmp", "a.bin"]);
}

#[cfg(unix)]
#[test]
fn links_are_followed() {
    let folder = tempfile::tempdir().unwrap();
    let (file, link) = (folder.path().join("file"), folder.path().join("link"));
    atomic_write(&file, b"one").unwrap();
    std::os::unix::fs::symlink(&file, &link).unwrap();
    atomic_write(&link, b"two").unwrap();
    assert_eq!(std::fs::read(&file).unwrap(), b"two");
    assert!(link.symlink_metadata().unwrap().is_symlink());
}

/// What is no plain file is written in place: renaming over it would replace it. A pipe of the
/// test's own stands for all of them, never a device of the system.
#[cfg(unix)]
#[test]
fn pipes_are_kept() {
    use std::os::unix::fs::FileTypeExt;
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe");
    let made = Command::new("mkfifo").arg(&pipe).status().unwrap();
    assert!(made.success());
    let from = pipe.clone();
    let reader = std::thread::spawn(move || std::fs::read(from).unwrap());
    atomic_write(&pipe, b"through").unwrap();
    assert_eq!(reader.join().unwrap(), b"through");
    assert!(
        std::fs::symlink_metadata(&pipe)
            .unwrap()
            .file_type()
            .is_fifo()
    );
    assert_eq!(names(folder.path()), ["pipe"]);
}

#[test]
fn what_cannot_be_written_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    atomic_write(&file, b"").unwrap();
    for path in [
        folder.path().to_path_buf(),
        file.join("a"),
        folder.path().join("no/a"),
    ] {
        let error = atomic_write(&path, b"x").unwrap_err();
        assert!(error.is_bad_input(), "{error}");
    }
    let error = create_folder(&file.join("a")).unwrap_err();
    assert!(error.is_bad_input(), "{error}");
    // A run folder that is a file.
    let error = write_part(&file, 0, &made::samples(0, 0, 1), &made::facts()).unwrap_err();
    assert!(matches!(&error, StoreError::Io { action, .. } if *action == "create the folder"));
}

/// A small file system of its own that fills up. Mounting needs root; where it is not allowed,
/// [`a_full_disk_could_be_tried_again`] is all that can be said.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_leaves_what_was_there() {
    let folder = tempfile::tempdir().unwrap();
    let mount = |args: &[&str]| {
        let status = Command::new("mount").args(args).arg(folder.path()).output();
        status.is_ok_and(|output| output.status.success())
    };
    if !mount(&["-t", "tmpfs", "-o", "size=256k", "tmpfs"]) {
        eprintln!("skipped: no right to mount");
        return;
    }
    let filled = std::panic::catch_unwind(|| fill(folder.path()));
    let status = Command::new("umount").arg(folder.path()).status();
    assert!(status.unwrap().success());
    filled.unwrap();
}

#[cfg(target_os = "linux")]
fn fill(run: &Path) {
    let small = made::samples(1, 0, 100);
    write_part(run, 0, &small, &made::facts()).unwrap();
    // The same part again, too large for the disk: the old one stays.
    let large = made::samples(1, 0, 10_000);
    let error = write_part(run, 0, &large, &made::facts()).unwrap_err();
    assert!(
        matches!(error, StoreError::Io { .. }) && !error.is_bad_input(),
        "{error}"
    );
    let cell = samples_folder(run).join("cell=000001");
    assert_eq!(names(&cell), ["part-00000.parquet"]);
    assert!(names(&staging_folder(run)).is_empty());
    let back = rrf_store::parts::read_part(run, 1, 0, &made::facts()).unwrap();
    assert_eq!(back, small);
}

#[test]
fn a_full_disk_could_be_tried_again() {
    let error = |kind: std::io::ErrorKind| StoreError::Io {
        path: "run".into(),
        action: "write",
        source: kind.into(),
    };
    let full = error(std::io::ErrorKind::StorageFull);
    assert!(!full.is_bad_input());
    assert!(full.to_string().contains("Free some space"), "{full}");
    assert!(error(std::io::ErrorKind::ReadOnlyFilesystem).is_bad_input());
}

#[test]
fn unfinished_files_are_removed_and_no_others() {
    let run = tempfile::tempdir().unwrap();
    let run = run.path();
    remove_unfinished(run).unwrap();
    let small = made::samples(1, 0, 3);
    write_part(run, 0, &small, &made::facts()).unwrap();
    let fit = run.join("rounds/000/fits/cell=000001");
    std::fs::create_dir_all(&fit).unwrap();
    let kept = [
        run.join("a.tmp"),
        run.join("run.json"),
        fit.join(".hidden"),
        fit.join(".x.tmp"),
        fit.join(".y..tmp"),
        fit.join("weights.arrow"),
    ];
    let left = [
        staging_folder(run).join("cell=000001-part-00000.parquet.0.tmp"),
        run.join(".run.json.0.tmp"),
        run.join("rounds/000/.plan.json.12.tmp"),
        fit.join(".weights.arrow.999.tmp"),
    ];
    for path in kept.iter().chain(&left) {
        std::fs::write(path, b"").unwrap();
    }
    remove_unfinished(run).unwrap();
    kept.iter()
        .for_each(|path| assert!(path.exists(), "{path:?}"));
    left.iter()
        .for_each(|path| assert!(!path.exists(), "{path:?}"));
    let back = rrf_store::parts::read_part(run, 1, 0, &made::facts()).unwrap();
    assert_eq!(back, small);
}
