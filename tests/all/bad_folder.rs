//! Output that cannot be written: the message says where and what to do, and what was there
//! stays.

use crate::program::{Place, TINY, bake_tiny, bytes_below, cornell, refused, rrf, says, tiny_run};

fn bake<'a>(scene: &'a str, run: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&["bake", scene, "-o", run], &TINY[..], more].concat()
}

/// A file where the folder should be, and a folder below a file: bad input, nothing changed.
#[test]
fn output_is_no_folder() {
    let (place, scene) = (Place::new(), cornell());
    let file = place.write("file", "mine");
    refused(&bake(&scene, &file, &[]), &[&file, "cannot"]);
    let below = place.name("file/run");
    refused(&bake(&scene, &below, &[]), &["file", "cannot"]);
    assert_eq!(std::fs::read(&file).expect("still there"), b"mine");
}

/// The disk is full: exit code 1 (it could succeed when tried again), and what to do.
#[cfg(target_os = "linux")]
#[test]
fn full_disk() {
    let place = Place::new();
    let full = place.name("full.exr");
    std::os::unix::fs::symlink("/dev/full", &full).expect("a link");
    let run = tiny_run();
    let said = rrf(&[
        "render", &run, "-o", &full, "--light", "0,1.6,0", "--size", "16x16",
    ]);
    assert_eq!(said.code, Some(1), "{said:#?}");
    says(&said, &["full.exr", "No space left"]);
}

/// The same for a run folder, on a file system of 200 kB; that takes a root's rights.
#[cfg(target_os = "linux")]
#[test]
fn full_output_folder() {
    let (place, scene) = (Place::new(), cornell());
    let disk = place.name("disk");
    std::fs::create_dir(&disk).expect("a folder");
    let mount = ["-t", "tmpfs", "-o", "size=200k", "rrf-test", &disk];
    let mounted = std::process::Command::new("mount").args(mount).output();
    if !mounted.is_ok_and(|o| o.status.success()) {
        println!("left out: no right to mount a small file system");
        return;
    }
    let run = format!("{disk}/run");
    let said = rrf(&bake(&scene, &run, &[]));
    let parts = bytes_below(&place.path("disk/run"));
    let grown = ["-o", "remount,size=20m", &disk];
    let grown = std::process::Command::new("mount").args(grown).status();
    let resumed = rrf(&bake(&scene, &run, &["--resume"]));
    let after = bytes_below(&place.path("disk/run"));
    let freed = std::process::Command::new("umount").arg(&disk).status();
    assert!(freed.is_ok_and(|s| s.success()) && grown.is_ok_and(|s| s.success()));
    assert_eq!(said.code, Some(1), "{said:#?}");
    says(
        &said,
        &["disk/run", "No space left", "Free some space", "--resume"],
    );
    assert!(
        parts.iter().all(|(name, _)| !name.contains("tmp")),
        "left-over files"
    );
    assert_eq!(resumed.code, Some(0), "{resumed:#?}");
    bake_tiny(&scene, &place.name("run"), &[]);
    assert!(
        bytes_below(&place.path("run")) == after,
        "not what a bake without pause makes"
    );
}

/// A folder that cannot be written, for a user who is not root.
#[cfg(unix)]
#[test]
fn unwritable_folder() {
    use std::os::unix::fs::PermissionsExt;
    let (place, scene) = (Place::new(), cornell());
    let locked = place.path("locked");
    std::fs::create_dir(&locked).expect("a folder");
    let read_only = std::fs::Permissions::from_mode(0o555);
    std::fs::set_permissions(&locked, read_only).expect("permissions");
    if std::fs::write(locked.join("probe"), "").is_ok() {
        println!("left out: this user may write everywhere");
        return;
    }
    let said = refused(
        &bake(&scene, &place.name("locked/run"), &[]),
        &["locked", "Permission denied"],
    );
    says(&said, &["Choose a folder that can be written"]);
}
