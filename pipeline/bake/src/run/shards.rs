//! Tasks read from their shards, as a worker on another machine needs them.

use crate::error::BakeError;
use crate::plan::shard::{Job, SHARD_TASKS, ShardEntry, TaskShard};
use crate::plan::task::TaskKind;
use crate::run::folder::Run;
use crate::run::json::read_json;
use rrf_store::layout::{cell_folder, chapter_path};
use std::path::Path;

impl Run {
    /// Reads a task of a round by its id, or the number of tasks where the id is beyond the last.
    ///
    /// # Errors
    /// [`BakeError::Plan`] for a file that is missing, damaged, or belongs to another run or another
    /// version of the program; [`BakeError::Store`].
    pub fn read_job(&self, round: u32, id: u32) -> Result<Result<Job, u32>, BakeError> {
        let wrong = |reason: &str| BakeError::Plan {
            round,
            reason: format!("task {id}: {reason}. Write the plan again with `rrf plan RUN`"),
        };
        let shard = |id: u32| -> Result<Option<TaskShard>, BakeError> {
            read_json(
                &chapter_path(&self.folder, round, id / SHARD_TASKS as u32),
                &self.hash()?,
            )
        };
        let Some(found) = shard(id)? else {
            // beyond the last shard, or lost
            let tasks = shard(0)?.map(|first| first.tasks);
            return match tasks {
                Some(tasks) if id >= tasks => Ok(Err(tasks)),
                _ => Err(wrong("the plan's file is missing")),
            };
        };
        if id >= found.tasks {
            return Ok(Err(found.tasks));
        }
        let at = id.checked_sub(found.first).map(|at| at as usize);
        let entry = at.and_then(|at| found.entries.get(at));
        let Some(ShardEntry { task, cell }) = entry.cloned() else {
            return Err(wrong("the plan's file does not contain it"));
        };
        let same_run =
            (found.seed, &found.scene_hash) == (self.manifest.seed, &self.manifest.scene_hash);
        let job = Job {
            task,
            facts: found.shared,
            cell,
        };
        let (parts, fit) = self.inputs().hashes(&job.facts, &job.cell)?;
        let hash = match job.task.kind {
            TaskKind::Train => Some(&fit),
            TaskKind::Extract => {
                let numbers = job.cell.plan.parts.iter().map(|p| Some(p.part));
                let mut hashed = numbers.zip(&parts);
                hashed.find(|(n, _)| *n == job.task.part).map(|(_, h)| h)
            }
        };
        if !same_run || hash != Some(&job.task.hash) {
            return Err(wrong("it does not belong to this run"));
        }
        Ok(Ok(job))
    }
}

impl Job {
    /// Prefixes of the names of the files that the task reads and writes, relative to the run.
    pub fn files(&self) -> Vec<String> {
        let (task, id) = (&self.task, self.task.cell);
        let parts_of = |cell| format!("{}/", cell_folder(Path::new(""), cell).display());
        let mut files = vec![parts_of(id)];
        match task.kind {
            TaskKind::Train => {
                let earlier = self.cell.plan.earlier.as_ref();
                let earlier = earlier.map(|fit| [fit.round, fit.cell]);
                let fits = std::iter::once([task.round, id]).chain(earlier);
                files.extend(
                    fits.map(|[round, cell]| format!("rounds/{round:03}/fits/cell={cell:06}/")),
                );
            }
            TaskKind::Extract => {
                let parts = self.cell.plan.parts.iter();
                let from = parts
                    .filter(|p| Some(p.part) == task.part)
                    .filter_map(|p| p.from);
                files.extend(from.map(|[cell, _]| parts_of(cell)));
            }
        }
        files
    }
}
