//! The rounds of a run: plans, tasks, evaluations, and how far the run has come.

use crate::error::BakeError;
use crate::plan::evaluation::EvaluatedRound;
use crate::plan::round::RoundPlan;
use crate::plan::task::{Task, TaskKind};
use crate::policy::tasks::{entries, shards, task_rows};
use crate::run::folder::Run;
use crate::run::json::{corrupt, read_json, remove_file, write_json};
use rrf_store::StoreError;
use rrf_store::atomic::create_folder;
use rrf_store::layout::{
    TEST, cell_folder, chapter_path, fit_folder, round_folder, samples_folder, task_table_path,
};
use rrf_store::parts::remove_part;
use rrf_store::task_table::write_tasks;
use rrf_store::{model, parts};
use std::collections::BTreeSet;

/// How far a run has come.
#[derive(Clone, Debug)]
pub struct Progress {
    /// The round that was committed last, if any.
    pub evaluated: Option<EvaluatedRound>,
    /// The round to do, or none where the run has ended.
    pub todo: Option<RoundPlan>,
}

impl Run {
    /// How far the run has come, from its files. A round that lost files has to be done again.
    ///
    /// # Errors
    /// [`BakeError::Store`].
    pub fn progress(&self) -> Result<Progress, BakeError> {
        let (mut evaluated, mut round) = (None, 0);
        while let Some(plan) = self.read_plan(round)? {
            let found = self.read_evaluated(round)?;
            let committed = found.is_some();
            let ended = found.as_ref().is_some_and(|found| found.stop.is_some());
            evaluated = found.or(evaluated);
            let lost = ended && (!self.has_model()? || self.unfinished(&plan)? > 0);
            if !committed || lost {
                return Ok(Progress {
                    evaluated,
                    todo: Some(plan),
                });
            }
            if ended {
                break;
            }
            round += 1;
        }
        Ok(Progress {
            evaluated,
            todo: None,
        })
    }

    /// The plan of a round, or none where it has not been made.
    ///
    /// # Errors
    /// [`BakeError::Store`].
    pub fn read_plan(&self, round: u32) -> Result<Option<RoundPlan>, BakeError> {
        let path = self.round_file(round, "plan.json");
        let plan: Option<RoundPlan> = read_json(&path, &self.hash()?)?;
        if let Some(plan) = &plan {
            plan.check().map_err(|reason| corrupt(&path, reason))?;
        }
        Ok(plan)
    }

    /// Writes the tasks of a round, then its plan: a round that has a plan is complete.
    ///
    /// # Errors
    /// [`BakeError::Store`].
    pub fn write_plan(&self, plan: &RoundPlan) -> Result<(), BakeError> {
        let path = task_table_path(&self.folder, plan.round);
        create_folder(&round_folder(&self.folder, plan.round))?;
        let (shards, hash) = (shards(self.inputs(), plan)?, self.hash()?);
        for (number, shard) in (0u32..).zip(&shards) {
            write_json(
                &chapter_path(&self.folder, plan.round, number),
                shard,
                &hash,
            )?;
        }
        let facts = self.facts();
        write_tasks(&path, &task_rows(&shards, facts.seed), &facts)?;
        // they belong to another plan of this round
        remove_file(&self.round_file(plan.round, "judged.json"))?;
        remove_file(&self.round_file(plan.round, "seconds.json"))?;
        write_json(&self.round_file(plan.round, "plan.json"), plan, &hash)
    }

    /// The evaluation of a round, or none where the round has not been committed.
    ///
    /// # Errors
    /// [`BakeError::Store`].
    pub fn read_evaluated(&self, round: u32) -> Result<Option<EvaluatedRound>, BakeError> {
        read_json(&self.round_file(round, "judged.json"), &self.hash()?)
    }

    /// The plan of the round before.
    pub(crate) fn plan_before(&self, plan: &RoundPlan) -> Result<Option<RoundPlan>, BakeError> {
        let before = plan.round.checked_sub(1);
        before.map_or(Ok(None), |round| self.read_plan(round))
    }

    /// The evaluation of the round before.
    pub(crate) fn evaluated_before(
        &self,
        plan: &RoundPlan,
    ) -> Result<Option<EvaluatedRound>, BakeError> {
        let before = plan.round.checked_sub(1);
        before.map_or(Ok(None), |round| self.read_evaluated(round))
    }

    /// Marks a round as committed.
    pub(crate) fn write_evaluated(&self, round: &EvaluatedRound) -> Result<(), BakeError> {
        write_json(
            &self.round_file(round.round, "judged.json"),
            round,
            &self.hash()?,
        )
    }

    /// All tasks of a round: extractions first, by cell and part, test rows after the cells'. Tasks
    /// whose output is kept from an earlier round are included, and done unless it was lost.
    ///
    /// # Errors
    /// [`BakeError::Plan`].
    pub fn tasks(&self, plan: &RoundPlan) -> Result<Vec<Task>, BakeError> {
        let entries = entries(self.inputs(), plan)?;
        Ok(entries.into_iter().map(|entry| entry.task).collect())
    }

    /// Whether the output of a task exists, whole. One that is damaged or of another run is not
    /// done: the task makes it again.
    ///
    /// # Errors
    /// [`BakeError::Store`] for an output that cannot be read.
    pub fn is_done(&self, task: &Task) -> Result<bool, BakeError> {
        let (folder, facts) = (&self.folder, self.facts());
        let found = match (task.kind, task.part) {
            (TaskKind::Extract, Some(part)) => parts::part_task(folder, task.cell, part, &facts),
            _ => model::fit_task(&fit_folder(folder, task.round, task.cell), &facts),
        };
        let found = match found {
            Err(error) if error.is_damage() => None,
            found => found?,
        };
        Ok(found.as_deref() == Some(task.hash.as_str()))
    }

    /// Removes the output of a task that an error names as damaged, so that the task is done again;
    /// false where it names none.
    ///
    /// # Errors
    /// [`BakeError::Store`] where it cannot be removed.
    pub(crate) fn discard(&self, damage: &StoreError) -> Result<bool, BakeError> {
        let Some(path) = damage.path().filter(|_| damage.is_damage()) else {
            return Ok(false);
        };
        let samples = [
            samples_folder(&self.folder),
            cell_folder(&self.folder, TEST),
        ];
        let is_fit = path.components().any(|part| part.as_os_str() == "fits");
        let is_output = samples.iter().any(|folder| path.starts_with(folder))
            || (is_fit && path.starts_with(&self.folder));
        if !is_output || !path.is_file() {
            return Ok(false);
        }
        remove_file(path)?;
        Ok(true)
    }

    /// Number of tasks of a round that are not done.
    ///
    /// # Errors
    /// As [`Run::is_done`].
    pub fn unfinished(&self, plan: &RoundPlan) -> Result<usize, BakeError> {
        let mut count = 0;
        for task in self.tasks(plan)? {
            count += usize::from(!self.is_done(&task)?);
        }
        Ok(count)
    }

    /// Removes parts of the round before that a round has replaced.
    pub(crate) fn remove_replaced(&self, plan: &RoundPlan) -> Result<(), BakeError> {
        let Some(before) = self.plan_before(plan)? else {
            return Ok(());
        };
        let needed: BTreeSet<[u32; 2]> = plan.part_ids().collect();
        for [cell, part] in before.part_ids().filter(|part| !needed.contains(part)) {
            remove_part(&self.folder, cell, part)?;
        }
        Ok(())
    }
}
