//! Folders that cannot be written, and writers that are interrupted.

use crate::made;
use rrf_store::StoreError;
use rrf_store::atomic::{atomic_write, create_folder};
use rrf_store::layout::{clean_staging, samples_folder, staging_folder};
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
fn links_are_followed_and_devices_kept() {
    use std::os::unix::fs::{FileTypeExt, symlink};
    let folder = tempfile::tempdir().unwrap();
    let (file, link) = (folder.path().join("file"), folder.path().join("link"));
    atomic_write(&file, b"one").unwrap();
    symlink(&file, &link).unwrap();
    atomic_write(&link, b"two").unwrap();
    assert_eq!(std::fs::read(&file).unwrap(), b"two");
    assert!(link.symlink_metadata().unwrap().is_symlink());
    atomic_write(Path::new("/dev/null"), b"gone").unwrap();
    let device = std::fs::metadata("/dev/null").unwrap();
    assert!(device.file_type().is_char_device());
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
    assert!(create_folder(&file.join("a")).unwrap_err().is_bad_input());
    // A run folder that is a file.
    let error = write_part(&file, 0, &made::samples(0, 0, 1), &made::facts()).unwrap_err();
    assert!(matches!(&error, StoreError::Io { action, .. } if *action == "create the folder"));
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_device_could_be_tried_again() {
    let error = atomic_write(Path::new("/dev/full"), b"x").unwrap_err();
    assert!(!error.is_bad_input(), "{error}");
    assert!(error.to_string().contains("Free some space"), "{error}");
}

/// A small file system of its own that fills up; mounting needs root, and without it (or in a
/// container that forbids it) `/dev/full` above is all that can be tried.
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
fn staging_is_emptied() {
    let run = tempfile::tempdir().unwrap();
    clean_staging(run.path()).unwrap();
    write_part(run.path(), 0, &made::samples(0, 0, 1), &made::facts()).unwrap();
    std::fs::write(staging_folder(run.path()).join("left.0.tmp"), b"").unwrap();
    clean_staging(run.path()).unwrap();
    assert!(!staging_folder(run.path()).exists());
}
