//! Output that cannot be written: the message says where and what to do, and what was there
//! stays.

use crate::program::{
    Place, TINY, bake_tiny, bytes_below, cornell, oracle, refused, rrf, says, tiny_run,
};

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
    let full = place.name("full.parquet");
    std::os::unix::fs::symlink("/dev/full", &full).expect("a link");
    let input = oracle("cornell_overhead");
    let said = rrf(&["query", &tiny_run(), "--points", &input, "-o", &full]);
    assert_eq!(said.code, Some(1), "{said:#?}");
    says(&said, &["full.parquet", "No space left"]);
}

/// A file system of 100 kB, which takes a root's rights.
#[cfg(target_os = "linux")]
struct SmallDisk(String);

#[cfg(target_os = "linux")]
impl SmallDisk {
    fn mount(folder: String) -> Option<SmallDisk> {
        std::fs::create_dir(&folder).expect("a folder");
        let mount = [
            "mount",
            "-t",
            "tmpfs",
            "-o",
            "size=100k",
            "rrf-test",
            &folder,
        ];
        call(&mount).then(|| SmallDisk(folder))
    }

    fn grow(&self) -> bool {
        call(&["mount", "-o", "remount,size=20m", &self.0])
    }
}

#[cfg(target_os = "linux")]
impl Drop for SmallDisk {
    fn drop(&mut self) {
        assert!(call(&["umount", &self.0]), "{} stays mounted", self.0);
    }
}

#[cfg(target_os = "linux")]
fn call(words: &[&str]) -> bool {
    let output = std::process::Command::new(words[0])
        .args(&words[1..])
        .output();
    output.is_ok_and(|o| o.status.success())
}

/// A run that filled its disk says so, leaves no half files, and goes on after there is space;
/// a frame does not appear by half.
#[cfg(target_os = "linux")]
#[test]
fn full_output_folder() {
    let (place, scene) = (Place::new(), cornell());
    let Some(disk) = SmallDisk::mount(place.name("disk")) else {
        println!("left out: no right to mount a small file system");
        return;
    };
    let run = format!("{}/run", disk.0);
    let said = rrf(&bake(&scene, &run, &[]));
    assert_eq!(said.code, Some(1), "{said:#?}");
    says(
        &said,
        &["disk/run", "No space left", "Free some space", "--resume"],
    );
    let files = bytes_below(&place.path("disk/run"));
    assert!(
        files.iter().all(|(name, _)| !name.contains("tmp")),
        "half a file"
    );

    let picture = format!("{}/a.exr", disk.0);
    let light = ["--light", "0,1.6,0", "--size", "256x256"];
    let said = rrf(&[&["render", &tiny_run(), "-o", &picture], &light[..]].concat());
    assert_eq!(said.code, Some(1), "{said:#?}");
    says(&said, &["a.exr", "No space left"]);
    assert_eq!(
        bytes_below(&place.path("disk")).len(),
        files.len(),
        "half a picture"
    );

    assert!(disk.grow(), "remount");
    bake_tiny(&scene, &run, &["--resume"]);
    bake_tiny(&scene, &place.name("run"), &[]);
    let resumed = bytes_below(&place.path("disk/run"));
    assert!(
        resumed == bytes_below(&place.path("run")),
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
