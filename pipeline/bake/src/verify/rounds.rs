//! The plans, shards and evaluations of all rounds.

use super::found::{Found, RESUME, noted};
use crate::error::BakeError;
use crate::plan::evaluation::EvaluatedRound;
use crate::plan::round::RoundPlan;
use crate::plan::shard::TaskShard;
use crate::policy::tasks::{shards, task_rows};
use crate::run::folder::Run;
use crate::run::json::{hash_in, read_json};
use rrf_store::layout::{chapter_path, round_folder, task_table_path};
use rrf_store::task_table::read_tasks;
use std::path::Path;

/// The rounds that have a plan.
pub(super) struct Rounds {
    /// From the first round on.
    pub plans: Vec<RoundPlan>,
    /// One a plan; none of the last where it is not committed.
    pub evaluated: Vec<Option<EvaluatedRound>>,
}

impl Rounds {
    /// The last committed round: the model is made of its fits.
    pub fn committed(&self) -> Option<&RoundPlan> {
        let last = self.evaluated.iter().rposition(Option::is_some)?;
        self.plans.get(last)
    }

    /// Whether the last round has been committed as the last one.
    pub fn ended(&self) -> bool {
        let last = self.evaluated.last().and_then(Option::as_ref);
        last.is_some_and(|evaluated| evaluated.stop.is_some())
    }
}

/// Reads the files of every round but its fits.
pub(super) fn check(run: &Run, found: &mut Found) -> Result<Rounds, BakeError> {
    let mut rounds = Rounds {
        plans: Vec::new(),
        evaluated: Vec::new(),
    };
    for round in 0.. {
        if !round_folder(&run.folder, round).exists() {
            break;
        }
        let path = run.round_file(round, "plan.json");
        found.known.insert(path.clone());
        let plan = noted(found, &path, run.read_plan(round), remedy(round))?;
        let Some(plan) = plan.flatten() else {
            if !path.exists() {
                found.damage(&path, "it is gone", remedy(round));
            }
            break;
        };
        hashed(&path, found)?;
        check_shards(run, &plan, found)?;
        let path = run.round_file(round, "seconds.json");
        found.known.insert(path.clone());
        noted(
            found,
            &path,
            run.read_timings(round),
            "Delete it: it only holds wall times",
        )?;
        let path = run.round_file(round, "judged.json");
        found.known.insert(path.clone());
        let again = format!("Delete it; {RESUME}");
        let evaluated = noted(found, &path, run.read_evaluated(round), again)?.flatten();
        hashed(&path, found)?;
        rounds.plans.push(plan);
        rounds.evaluated.push(evaluated);
    }
    // a round is planned by the commit of the one before
    let before_last = rounds.evaluated.len().saturating_sub(1);
    for (round, evaluated) in (0..).zip(rounds.evaluated.iter().take(before_last)) {
        let path = run.round_file(round, "judged.json");
        if evaluated.is_none() && !path.exists() {
            found.damage(&path, "it is gone", RESUME);
        }
    }
    Ok(rounds)
}

fn remedy(round: u32) -> String {
    match round.checked_sub(1) {
        None => format!("Delete the folder `rounds`; {RESUME}"),
        Some(before) => format!(
            "Delete rounds/{before:03}/judged.json and the rounds from {round:03} on; {RESUME}"
        ),
    }
}

/// A file that lost its hash was changed by hand.
fn hashed(path: &Path, found: &mut Found) -> Result<(), BakeError> {
    if let Ok(text) = std::fs::read(path)
        && hash_in(&text).is_none()
    {
        let remedy = "Restore it from a backup, or bake into a new folder";
        found.damage(path, "it has no hash: it was changed by hand", remedy);
    }
    Ok(())
}

/// The task table and the shards, which schedulers read.
fn check_shards(run: &Run, plan: &RoundPlan, found: &mut Found) -> Result<(), BakeError> {
    const REMEDY: &str = "`rrf plan RUN` writes it again while its round is open; a round that is \
                          committed does not need it: delete it";
    let expected = shards(run.inputs(), plan)?;
    let facts = run.facts();
    let path = task_table_path(&run.folder, plan.round);
    found.known.insert(path.clone());
    let rows = read_tasks(&path, &facts).map_err(BakeError::from);
    if let Some(rows) = noted(found, &path, rows, REMEDY)?
        && rows != task_rows(&expected, facts.seed)
    {
        found.damage(&path, "its tasks are not those of the plan", REMEDY);
    }
    for (number, expected) in (0..).zip(&expected) {
        let path = chapter_path(&run.folder, plan.round, number);
        found.known.insert(path.clone());
        let shard = noted(
            found,
            &path,
            read_json::<TaskShard>(&path, &run.hash()?),
            REMEDY,
        )?;
        match shard {
            Some(Some(shard)) if shard.hashes() != expected.hashes() => {
                found.damage(&path, "its tasks are not those of the plan", REMEDY);
            }
            Some(None) => found.damage(&path, "it is gone", REMEDY),
            _ => {}
        }
    }
    Ok(())
}

impl TaskShard {
    /// The hashes of its tasks, which everything in it goes into.
    fn hashes(&self) -> Vec<&str> {
        let entries = self.entries.iter();
        entries.map(|entry| entry.task.hash.as_str()).collect()
    }
}
