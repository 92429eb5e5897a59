//! The bake of a transfer: its bytes, its resumption, and what happens to damaged tables.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use rrf_bake::{
    BakeError, Halt, Preset, Run, TransferBakeConfig, TransferRun, Watch, bake_scene_transfer,
    verify,
};
use rrf_extract::Region;
use rrf_scene::{LoadOptions, Scene, load};
use rrf_store::model::{TRANSFER_TABLES, model_table_path, read_transfer};
use rrf_store::schema::Table;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

fn cornell() -> Scene {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../scenes/cornell-box/scene.pbrt"
    );
    load(path.as_ref(), &LoadOptions::default()).unwrap()
}

fn small(seed: u64) -> TransferBakeConfig {
    let mut config = TransferBakeConfig::preset(Preset::Preview, seed);
    (config.patches, config.rows, config.paths) = (100, 300, 32);
    (config.points, config.suns, config.skies) = (30, 4, 2);
    config
}

fn bytes(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let paths = TRANSFER_TABLES.map(|table| model_table_path(folder, table));
    let read = |path: PathBuf| {
        let name = path.strip_prefix(folder).unwrap().to_path_buf();
        (name, std::fs::read(&path).unwrap())
    };
    paths.into_iter().map(read).collect()
}

/// Stops after so many questions.
struct Impatient(AtomicU32);

impl Watch for Impatient {
    fn halted(&self) -> Option<Halt> {
        let left = self
            .0
            .fetch_update(Ordering::Relaxed, Ordering::Relaxed, |n| {
                Some(n.saturating_sub(1))
            });
        (left == Ok(0)).then_some(Halt::Interrupt)
    }
}

#[test]
fn bytes_do_not_depend_on_threads_or_interruptions() {
    let scene = cornell();
    let config = small(1);
    let folders: Vec<_> = (0..3).map(|_| tempfile::tempdir().unwrap()).collect();
    let mut found = Vec::new();
    for (folder, threads) in folders.iter().zip([1, 2, 7]) {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let outcome = (pool.unwrap())
            .install(|| bake_scene_transfer(&scene, &config, folder.path(), false, &()))
            .unwrap();
        assert!(!outcome.was_finished && outcome.summary.cells > 5);
        let test = outcome.summary.test;
        assert!(test.relative_error > 0.0 && test.median_error <= test.percentile_95);
        assert!(test.test_rows > 50 && test.trusted_share <= 1.0);
        found.push(bytes(folder.path()));
    }
    assert!(found[0] == found[1] && found[0] == found[2]);

    // stopped at several places, and resumed
    let folder = tempfile::tempdir().unwrap();
    for (turn, questions) in [0, 1, 20, 38, 45].into_iter().enumerate() {
        let watch = Impatient(AtomicU32::new(questions));
        let resume = turn > 0;
        let stopped = bake_scene_transfer(&scene, &config, folder.path(), resume, &watch);
        let is_halted = matches!(
            stopped,
            Err(BakeError::TransferHalted {
                why: Halt::Interrupt
            })
        );
        assert!(is_halted, "{questions}: {stopped:?}");
        let checked = verify(folder.path()).unwrap();
        assert!(checked.damages.is_empty(), "{checked:?}");
    }
    // stopped once cells are done: those are kept
    let progress = model_table_path(folder.path(), Table::TransferProgress);
    let later = |&questions: &u32| Some(questions + questions / 8);
    let kept = std::iter::successors(Some(50), later)
        .take(40)
        .find(|&questions| {
            let watch = Impatient(AtomicU32::new(questions));
            let stopped = bake_scene_transfer(&scene, &config, folder.path(), true, &watch);
            assert!(stopped.is_err(), "{questions}");
            progress.exists()
        });
    assert!(kept.is_some());
    assert!(verify(folder.path()).unwrap().damages.is_empty());
    let again = bake_scene_transfer(&scene, &config, folder.path(), false, &());
    assert!(matches!(again, Err(BakeError::Exists { .. })), "{again:?}");
    let made = bake_scene_transfer(&scene, &config, folder.path(), true, &()).unwrap();
    assert!(!made.was_finished && !progress.exists());
    assert!(bytes(folder.path()) == found[0]);
    let kept = bake_scene_transfer(&scene, &config, folder.path(), true, &()).unwrap();
    assert!(kept.was_finished);
    assert_eq!(kept.summary, made.summary);
    let other = bake_scene_transfer(&scene, &small(2), folder.path(), true, &());
    assert!(
        matches!(other, Err(BakeError::OtherRun { .. })),
        "{other:?}"
    );
}

/// Holds a bake to some memory.
struct Tight(u64);

impl Watch for Tight {
    fn memory(&self) -> Option<u64> {
        Some(self.0)
    }
}

/// Rows that do not fit into memory are refused before one is traced; a limit that holds changes nothing.
#[test]
fn memory_is_asked_for_before_work() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let refused = bake_scene_transfer(&cornell(), &small(1), path, false, &Tight(1 << 20));
    let Err(error @ BakeError::TransferMemory { needed, .. }) = refused else {
        panic!("{refused:?}");
    };
    assert!(needed > 1 << 20 && error.is_bad_input(), "{error}");
    assert!(!path.join("model").exists());
    bake_scene_transfer(&cornell(), &small(1), path, true, &Tight(needed)).unwrap();
    let free = tempfile::tempdir().unwrap();
    bake_scene_transfer(&cornell(), &small(1), free.path(), false, &()).unwrap();
    assert!(bytes(path) == bytes(free.path()));
}

/// A light box inside a solid is refused before anything is written.
#[test]
fn refusals_leave_no_run() {
    let folder = tempfile::tempdir().unwrap();
    let mut config = small(1);
    config.light_box = Some(Region {
        minimum: [0.3, 0.1, 0.3],
        maximum: [0.4, 0.2, 0.4],
    });
    let refused = bake_scene_transfer(&cornell(), &config, folder.path(), false, &());
    assert!(matches!(refused, Err(BakeError::Extract(_))), "{refused:?}");
    assert!(!folder.path().join("run.json").exists());
}

/// Every table, damaged in a byte, missing or of another run, is refused and named, and made again.
#[test]
fn damaged_tables_are_refused_and_made_again() {
    let scene = cornell();
    let unlit = scene.unlit();
    let (folder, other) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let path = folder.path();
    bake_scene_transfer(&scene, &small(1), path, false, &()).unwrap();
    let mut elsewhere = small(1);
    elsewhere.rows = 200;
    bake_scene_transfer(&scene, &elsewhere, other.path(), false, &()).unwrap();
    let good = bytes(path);
    let run = TransferRun::open(path).unwrap();
    run.model(&unlit).unwrap();
    let tables = read_transfer(path, &run.facts()).unwrap();
    let refused = |what: &str, table: &Path| {
        let Err(error) = run.model(&unlit) else {
            panic!("{what} is taken");
        };
        assert!(error.is_bad_input(), "{what} {error}");
        let found = verify(path).unwrap();
        assert_eq!(found.damages.len(), 1, "{what} {found:?}");
        assert_eq!(found.damages[0].path, table, "{what}");
    };
    for table in TRANSFER_TABLES {
        let file = model_table_path(path, table);
        let name = file.file_name().unwrap();
        let whole = std::fs::read(&file).unwrap();
        // a flipped bit is found, or lies in padding or in a column's description
        let mut found = 0;
        for at in (0..whole.len()).step_by(whole.len() / 150) {
            let mut flipped = whole.clone();
            flipped[at] ^= 4;
            std::fs::write(&file, &flipped).unwrap();
            match read_transfer(path, &run.facts()) {
                Ok(read) => assert!(read == tables, "{} byte {at}", file.display()),
                Err(error) => {
                    assert!(error.is_damage(), "{error}");
                    found += 1;
                }
            }
        }
        assert!(found > 30, "{}: {found}", file.display());
        std::fs::copy(other.path().join("model").join(name), &file).unwrap();
        refused("of another run", &file);
        std::fs::remove_file(&file).unwrap();
        refused("missing", &file);
        let mended = bake_scene_transfer(&scene, &small(1), path, true, &()).unwrap();
        assert!(!mended.was_finished);
        assert!(bytes(path) == good);
    }
    // a program for nets says what it needs
    let error = Run::open(path).unwrap_err();
    assert!(matches!(error, BakeError::Method { .. }), "{error}");
    // another scene has other patches
    let mut less = unlit.clone();
    less.triangles.pop();
    less.triangle_material.pop();
    less.triangle_light.pop();
    less.triangle_object.pop();
    let error = run.model(&less).err().unwrap();
    assert!(error.to_string().contains("other patches"), "{error}");
}
