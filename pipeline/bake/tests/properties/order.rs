//! Tasks in any order, any number of times, with outputs lost in between: the same bytes.

use crate::room::{files, with_run};
use proptest::prelude::*;
use rrf_bake::{
    BakeError, Job, RoundPlan, Run, SamplingContext, Task, TaskKind, evaluate_round,
    extract_samples, perform, train_nets,
};
use rrf_store::layout::fit_folder;
use rrf_store::parts::remove_part;
use std::collections::BTreeMap;
use std::sync::OnceLock;

fn finish(run: &Run, plan: &RoundPlan, context: &SamplingContext) -> BTreeMap<String, Vec<u8>> {
    extract_samples(run, plan, context, None, &()).unwrap();
    train_nets(run, plan, &()).unwrap();
    assert_eq!(run.unfinished(plan).unwrap(), 0);
    evaluate_round(run, plan, &()).unwrap();
    files(&run.folder)
}

fn lose(run: &Run, task: &Task) {
    match task.part {
        Some(part) => remove_part(&run.folder, task.cell, part).unwrap(),
        None => {
            let _ = std::fs::remove_dir_all(fit_folder(&run.folder, task.round, task.cell));
        }
    }
}

/// The bytes of tasks done once, in the plan's order.
fn expected() -> &'static BTreeMap<String, Vec<u8>> {
    static FILES: OnceLock<BTreeMap<String, Vec<u8>>> = OnceLock::new();
    FILES.get_or_init(|| with_run(finish))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4))]

    #[test]
    fn order_and_losses_leave_no_trace(
        steps in prop::collection::vec((0..100usize, prop::bool::weighted(0.2)), 0..20)
    ) {
        let found = with_run(|run, plan, context| -> Result<_, TestCaseError> {
            let tasks = run.tasks(plan).unwrap();
            prop_assert_eq!(run.unfinished(plan).unwrap(), tasks.len());
            for (index, lost) in steps {
                let task = &tasks[index % tasks.len()];
                match lost {
                    true => lose(run, task),
                    false => match perform(run, &Job::of(plan, task).unwrap(), Some(context), None, None) {
                        Ok(()) => prop_assert!(run.is_done(task).unwrap()),
                        Err(BakeError::NotExtracted { .. }) => {
                            prop_assert_eq!(task.kind, TaskKind::Train);
                        }
                        Err(error) => panic!("{error}"),
                    },
                }
            }
            Ok(finish(run, plan, context))
        })?;
        prop_assert_eq!(found.keys().collect::<Vec<_>>(), expected().keys().collect::<Vec<_>>());
        for (name, bytes) in &found {
            prop_assert_eq!(Some(bytes), expected().get(name), "{}", name);
        }
    }
}
