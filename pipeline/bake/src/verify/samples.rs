//! The outputs of tasks: parts of cells, test rows, fits.

use super::found::{Found, RESUME, noted};
use super::rounds::Rounds;
use crate::error::BakeError;
use crate::plan::round::RoundPlan;
use crate::plan::task::{Task, TaskKind};
use crate::run::folder::Run;
use rayon::prelude::*;
use rrf_store::layout::{fit_folder, part_path};
use rrf_store::{StoreError, model, parts};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Reads the outputs of all tasks. Returns how many tasks of an open round are not done.
pub(super) fn check(run: &Run, rounds: &Rounds, found: &mut Found) -> Result<usize, BakeError> {
    // by output: tasks of several rounds keep one, and the last plan says what it must be
    let mut wanted: BTreeMap<PathBuf, (Task, bool)> = BTreeMap::new();
    for (i, plan) in rounds.plans.iter().enumerate() {
        let is_last = i + 1 == rounds.plans.len();
        let parts = is_last
            || rounds
                .committed()
                .is_some_and(|last| last.round == plan.round);
        for task in run.tasks(plan)? {
            // parts that a later round replaced are gone
            if parts || task.kind == TaskKind::Train {
                let needed = is_needed(rounds, plan, &task);
                wanted.insert(output(run, &task), (task, needed));
            }
        }
    }
    let checked: Vec<(Found, usize)> = wanted
        .par_iter()
        .map(|(_, (task, needed))| check_task(run, task, *needed, rounds.ended()))
        .collect::<Result<_, BakeError>>()?;
    let mut open = 0;
    for (of_task, missing) in checked {
        found.add(of_task);
        open += missing;
    }
    Ok(open)
}

/// Whether the model, or the round to do, depends on a task's output.
fn is_needed(rounds: &Rounds, plan: &RoundPlan, task: &Task) -> bool {
    let last = rounds
        .plans
        .last()
        .is_some_and(|last| last.round == plan.round);
    let committed = rounds
        .committed()
        .is_some_and(|last| last.round == plan.round);
    last || (committed && task.kind == TaskKind::Train)
}

fn output(run: &Run, task: &Task) -> PathBuf {
    match (task.kind, task.part) {
        (TaskKind::Extract, Some(part)) => part_path(&run.folder, task.cell, part),
        _ => fit_folder(&run.folder, task.round, task.cell),
    }
}

fn check_task(
    run: &Run,
    task: &Task,
    needed: bool,
    ended: bool,
) -> Result<(Found, usize), BakeError> {
    let mut found = Found::default();
    let (path, facts) = (output(run, task), run.facts());
    let remedy = match needed {
        true => RESUME.to_owned(),
        false => "The model does not need it any more: delete it".to_owned(),
    };
    let hash = match (task.kind, task.part) {
        (TaskKind::Extract, Some(part)) => {
            found.known.insert(path.clone());
            let read = || -> Result<Option<String>, StoreError> {
                let hash = parts::part_task(&run.folder, task.cell, part, &facts)?;
                if hash.is_some() {
                    parts::read_part(&run.folder, task.cell, part, &facts)?;
                }
                Ok(hash)
            };
            noted(
                &mut found,
                &path,
                read().map_err(BakeError::from),
                remedy.as_str(),
            )?
        }
        _ => {
            let tables =
                ["weights", "metrics", "steps"].map(|name| path.join(format!("{name}.arrow")));
            found.known.extend(tables);
            let mut has_steps = true;
            let mut read = || -> Result<Option<String>, StoreError> {
                let hash = model::fit_task(&path, &facts)?;
                if hash.is_some() {
                    has_steps = model::read_steps(&path, &facts)?.is_some();
                }
                Ok(hash)
            };
            let hash = noted(
                &mut found,
                &path,
                read().map_err(BakeError::from),
                remedy.as_str(),
            )?;
            if !has_steps {
                let remedy =
                    "Only charts of the fit need it: delete the folder and resume, or leave it";
                found.damage(&path.join("steps.arrow"), "it is gone", remedy);
            }
            hash
        }
    };
    let mut open = 0;
    match hash {
        // damaged: noted above
        None => open += usize::from(needed),
        Some(Some(hash)) if hash == task.hash => {}
        Some(Some(_)) => {
            open += usize::from(needed);
            found.damage(&path, "it was made from another plan or run", remedy);
        }
        Some(None) if needed && ended => found.damage(&path, "it is gone", remedy),
        Some(None) => open += usize::from(needed),
    }
    Ok((found, open))
}
