//! Whatever a plan says: it is refused, or its tasks are those of its cells and parts.

use crate::room::with_run;
use proptest::prelude::*;
use rrf_bake::{CellPlan, DrawPlan, PartPlan, RoundPlan};
use rrf_field::tree::Tree;
use std::collections::BTreeSet;

fn tree() -> impl Strategy<Value = Tree> {
    let node = (
        -2..4i8,
        -1.0..1.0f32,
        0..8u32,
        prop_oneof![0..5u32, Just(u32::MAX)],
    );
    // grown by splits, or of any columns at all
    let any = prop::collection::vec(node, 0..7).prop_map(|nodes| Tree {
        axis: nodes.iter().map(|node| node.0).collect(),
        threshold: nodes.iter().map(|node| node.1).collect(),
        left: nodes.iter().map(|node| node.2).collect(),
        cell: nodes.iter().map(|node| node.3).collect(),
    });
    let grown = prop::collection::vec((0..100usize, 0..3usize, -1.0..1.0f32), 0..5);
    let grown = grown.prop_map(|splits| {
        let mut tree = Tree::single();
        for (new, (leaf, axis, at)) in (1u32..).zip(splits) {
            let leaves = tree.leaves();
            tree.split(leaves[leaf % leaves.len()], axis, at, new);
        }
        tree
    });
    prop_oneof![any, grown]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4))]

    #[test]
    fn a_plan_is_refused_or_has_its_tasks(
        trees in prop::collection::vec(tree(), 32),
        draws in prop::collection::vec((0..12u32, 0..9u32), 0..4),
        parts in prop::collection::vec((0..3u32, 0..4u32), 0..3),
        (shift, fitted) in (0..2u32, 0..2u32),
    ) {
        with_run(|run, plan, _| -> Result<(), TestCaseError> {
            for tree in &trees {
                let part = |&(part, draw): &(u32, u32)| PartPlan { part, draw, from: None };
                let cell = |cell| CellPlan {
                    cell: cell + shift,
                    parts: parts.iter().map(part).collect(),
                    fitted,
                    ..plan.cells[0].clone()
                };
                let draw = |&(node, rows): &(u32, u32)| DrawPlan { node, rows, paths: 2 };
                let made = RoundPlan {
                    cells: (0..tree.cells() as u32).map(cell).collect(),
                    draws: draws.iter().map(draw).collect(),
                    tests: parts.iter().map(part).collect(),
                    tree: tree.clone(),
                    ..plan.clone()
                };
                let sound = tree.check().is_ok()
                    && shift == 0
                    && fitted == 0
                    && draws.iter().all(|&(node, _)| (node as usize) < tree.axis.len())
                    && parts.iter().all(|&(_, draw)| (draw as usize) < draws.len());
                prop_assert_eq!(made.check().is_ok(), sound);
                if sound {
                    let tasks = run.tasks(&made).unwrap();
                    prop_assert_eq!(tasks.len(), made.cells.len() * (1 + parts.len()) + parts.len());
                    let hashes: BTreeSet<_> = tasks.iter().map(|task| &task.hash).collect();
                    let fits = tasks.iter().filter(|task| task.part.is_none()).count();
                    prop_assert_eq!(fits, made.cells.len());
                    prop_assert!(hashes.len() >= fits);
                }
            }
            Ok(())
        })?;
    }
}

/// The fuzz targets begin with a run that opens, and with a plan, a evaluation and tasks that are read
/// to the end: a field that is added goes there too, and a version of the program makes other hashes
/// (`rrf plan` in a folder of the seeds `run.json` and `plan.json`, without their first byte, writes them).
#[test]
fn the_fuzz_targets_run_opens() {
    let seeds = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fuzz/seeds/small/");
    let folder = tempfile::tempdir().unwrap();
    let put = |seed: &str, to: &str| {
        let bytes = std::fs::read(format!("{seeds}{seed}")).unwrap();
        let to = folder.path().join(to);
        std::fs::create_dir_all(to.parent().unwrap()).unwrap();
        // a byte before it says which reader it is for
        std::fs::write(to, &bytes[1..]).unwrap();
    };
    put("run.json", "run.json");
    put("plan.json", "rounds/000/plan.json");
    put("judged.json", "rounds/000/judged.json");
    put("chapter.json", "rounds/000/tasks/00000.json");
    let run = rrf_bake::Run::open(folder.path()).unwrap();
    let plan = run.read_plan(0).unwrap().unwrap();
    assert!(!run.tasks(&plan).unwrap().is_empty());
    let judged = run.read_evaluated(0).unwrap().unwrap();
    assert!(!judged.refinements.is_empty());
    run.read_job(0, 0).unwrap().unwrap();
}
