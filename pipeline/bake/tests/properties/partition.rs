//! After any splits every row of a draw is in exactly one cell's part, and it does not matter
//! whether a part's rows are taken from an earlier part or drawn anew.

use crate::room::{files, with_run};
use proptest::prelude::*;
use rrf_bake::{CellPlan, PartPlan, RoundPlan, Run};
use rrf_field::columns::COUNT;
use rrf_store::layout::samples_folder;
use rrf_store::parts::read_part;
use rrf_store::samples::SampleTable;

fn parts(run: &Run, plan: &RoundPlan) -> Vec<SampleTable> {
    let places = plan.cells.iter().flat_map(|cell| {
        let id = cell.cell;
        cell.parts.iter().map(move |part| (id, part.part))
    });
    places
        .map(|(cell, part)| read_part(&run.folder, cell, part, &run.facts()).unwrap())
        .collect()
}

/// Indices of rows, which name draw and row, with the bits of their columns and targets.
fn rows(tables: &[SampleTable]) -> Vec<(u64, Vec<u32>)> {
    let bits = |table: &SampleTable, row: usize| {
        let columns = table.columns.row(row).map(f32::to_bits);
        let halves = table.halves.iter().flat_map(|half| half[row]);
        columns
            .into_iter()
            .chain(halves.map(f32::to_bits))
            .collect()
    };
    let mut all: Vec<(u64, Vec<u32>)> = tables
        .iter()
        .flat_map(|table| (0..table.len()).map(|row| (table.index[row], bits(table, row))))
        .collect();
    all.sort();
    all
}

/// The next round: leaf after leaf is split where one of its first cell's rows lies.
fn split(plan: &RoundPlan, tables: &[SampleTable], picks: &[[usize; 3]]) -> RoundPlan {
    let mut next = RoundPlan {
        round: 1,
        ..plan.clone()
    };
    let mut origins: Vec<usize> = (0..plan.cells.len()).collect();
    for &[cell, axis, row] in picks {
        let cell = cell % next.cells.len();
        let column = &tables[origins[cell]].columns.columns[axis % COUNT];
        let leaf = next.tree.leaves()[cell];
        let new = next.cells.len() as u32;
        next.tree
            .split(leaf, axis % COUNT, column[row % column.len()], new);
        origins.push(origins[cell]);
        next.cells.push(CellPlan {
            cell: new,
            ..next.cells[cell].clone()
        });
    }
    for (cell, &origin) in next.cells.iter_mut().zip(&origins) {
        if origins.iter().filter(|&&other| other == origin).count() > 1 {
            let old = &plan.cells[origin].parts;
            let first = match cell.cell as usize == origin {
                true => 1 + old.iter().map(|part| part.part).max().unwrap(),
                false => 0,
            };
            let taken = |(part, old): (u32, &PartPlan)| PartPlan {
                part,
                draw: old.draw,
                from: Some([origin as u32, old.part]),
            };
            cell.parts = (first..).zip(old).map(taken).collect();
            cell.fitted = 1;
        }
    }
    next.check().unwrap();
    next
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]

    #[test]
    fn every_row_is_in_one_part(
        picks in prop::collection::vec([0..100usize, 0..COUNT, 0..1000usize], 1..6)
    ) {
        with_run(|run, plan, context| -> Result<(), TestCaseError> {
            let extract = |plan| rrf_bake::extract_samples(run, plan, context, None, &());
            extract(plan).unwrap();
            let before = parts(run, plan);
            prop_assert!(before.iter().all(|table| !table.is_empty()));
            let next = split(plan, &before, &picks);
            extract(&next).unwrap();
            let after = parts(run, &next);
            prop_assert_eq!(rows(&before), rows(&after));
            for table in &after {
                let cells = next.tree.find_all(&table.columns);
                prop_assert!(cells.iter().all(|&cell| cell == table.cell_id));
            }
            // the earlier round's parts are lost: drawn anew, the same bytes
            let taken = files(&samples_folder(&run.folder));
            std::fs::remove_dir_all(samples_folder(&run.folder)).unwrap();
            extract(&next).unwrap();
            for (name, bytes) in files(&samples_folder(&run.folder)) {
                prop_assert_eq!(Some(&bytes), taken.get(&name), "{}", name);
            }
            prop_assert_eq!(rows(&after), rows(&parts(run, &next)));
            Ok(())
        })?;
    }
}
