use super::*;
use crate::policy::held_out::is_held_out;
use rrf_field::columns;
use rrf_store::manifest::{FORMAT, RunManifest};

const PX: usize = columns::P;
const LX: usize = columns::L;
const ROWS: usize = 400;

/// A run in a folder, of which only the seed and the parts matter.
fn empty_run(folder: &std::path::Path) -> Run {
    let light_box = rrf_extract::Region {
        minimum: [0.0; 3],
        maximum: [1.0; 3],
    };
    Run {
        folder: folder.into(),
        manifest: RunManifest {
            format: FORMAT,
            created_by: "rrf".into(),
            scene: "scene".into(),
            scene_hash: "0123456789abcdef".repeat(4),
            seed: 7,
            light_box: [0.0, 0.0, 0.0, 1.0, 1.0, 1.0],
            config: serde_json::Value::Null,
            kernels: None,
        },
        config: crate::BakeConfig::preset(crate::Preset::Standard, light_box, 7),
        lock: None,
    }
}

/// A held-out row that no net can be evaluated at.
fn odd_one() -> u64 {
    (0..).find(|&i| is_held_out(7, i)).unwrap()
}

/// Part `number` of cell 0: `rows` rows from index `first` on, each with its index as px.
fn write_part(run: &Run, number: u32, first: u64, rows: u64) {
    let mut table = SampleTable::default();
    for index in first..first + rows {
        let mut row = [0.5; columns::COUNT];
        row[PX] = index as f32;
        row[LX] = if index == odd_one() { f32::NAN } else { 0.5 };
        table.index.push(index);
        table.columns.push(row);
        table.material.push(0);
        table.halves.iter_mut().for_each(|half| half.push([1.0; 3]));
        table.paths.push(8);
    }
    parts::write_part(&run.folder, number, &table, &run.facts()).unwrap();
}

/// The first held-out rows, from the newest part on and no further back than it takes: the oldest
/// part is not there.
#[test]
fn rows_are_the_first_held_out_of_the_newest_parts() {
    let folder = tempfile::tempdir().unwrap();
    let run = empty_run(folder.path());
    for (number, first, rows) in [(1, 5_000, 1_000), (2, 0, 0), (4, 0, 900)] {
        write_part(&run, number, first, rows);
    }
    let mut cell = crate::policy::first::one_cell(8).cells.remove(0);
    cell.parts = [0, 1, 2, 4]
        .map(|part| crate::plan::round::PartPlan {
            part,
            draw: 0,
            from: None,
        })
        .into();
    let found = held_out_rows(&run, &cell, ROWS).unwrap();
    let wanted: Vec<f32> = (0..900)
        .filter(|&i| i != odd_one())
        .chain(5_000..6_000)
        .filter(|&i| is_held_out(7, i))
        .map(|i| i as f32)
        .take(ROWS)
        .collect();
    assert_eq!((wanted.len(), &found.columns[PX]), (ROWS, &wanted));
    cell.parts.drain(..2);
    let all = held_out_rows(&run, &cell, ROWS).unwrap();
    assert!(all.len() < ROWS && all.columns[PX] == wanted[..all.len()]);
}
