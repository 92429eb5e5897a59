//! What became of the runs of a batch: `summary.json`.

use crate::clock::iso;
use rrf_bake::{Preset, Run};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// What became of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum State {
    /// The target is met.
    Done,
    /// Baked, but its target is missed.
    TargetMissed,
    /// Stopped by a signal or its time limit; the same command goes on with it.
    Stopped,
    /// Not begun for want of time, or after a signal.
    NotBegun,
    /// Failed; it may succeed if tried again.
    Failed,
    /// Its scene or settings are wrong.
    BadInput,
}

/// A bake that is finished.
pub struct Ended {
    /// Relative error and its standard error.
    pub error: (f64, f64),
    /// Whether the target is met.
    pub met: bool,
    /// Cells of the model.
    pub cells: usize,
    /// Rounds that are done.
    pub rounds: u32,
    /// Why there is no further round.
    pub stop: String,
}

/// What became of a run, and what it came to.
#[derive(Clone, Debug, Serialize)]
pub struct Outcome {
    /// Its folder.
    pub run: PathBuf,
    /// Its scene file.
    pub scene: PathBuf,
    /// Amount of work asked for.
    pub preset: Option<Preset>,
    /// Seed; none where the settings could not be read.
    pub seed: Option<u64>,
    /// 0 done, 1 failed, 2 bad input, 3 target missed where it is required.
    pub code: u8,
    /// In words.
    pub state: State,
    /// When work on it began, UTC.
    pub started: String,
    /// Wall time of this command \[s\].
    pub seconds: f64,
    /// Wall time of all its stages, those of earlier commands included \[s\].
    pub work_seconds: Option<f64>,
    /// Core time that the tasks of all its rounds were predicted to take \[s\].
    pub forecast_core_seconds: Option<f64>,
    /// Relative error to reach.
    pub target: Option<f32>,
    /// Whether it is reached, a standard error of its square included.
    pub target_met: Option<bool>,
    /// Why there is no further round.
    pub stop: Option<String>,
    /// Rounds that are done.
    pub rounds: Option<u32>,
    /// Cells of the model.
    pub cells: Option<usize>,
    /// Bytes of the whole run and of its model.
    pub bytes: Option<u64>,
    /// Bytes of the model alone.
    pub model_bytes: Option<u64>,
    /// Relative error on test rows, or where there are none on held-out rows.
    pub relative_error: Option<f64>,
    /// Its standard error.
    pub relative_error_se: Option<f64>,
    /// What happened, for people.
    pub message: String,
}

impl Outcome {
    /// Of a run on which no work was done.
    pub fn without_work(
        run: PathBuf,
        scene: PathBuf,
        (code, state): (u8, State),
        message: String,
    ) -> Outcome {
        Outcome {
            run,
            scene,
            preset: None,
            seed: None,
            code,
            state,
            started: iso(SystemTime::now()),
            seconds: 0.0,
            work_seconds: None,
            forecast_core_seconds: None,
            target: None,
            target_met: None,
            stop: None,
            rounds: None,
            cells: None,
            bytes: None,
            model_bytes: None,
            relative_error: None,
            relative_error_se: None,
            message,
        }
    }

    /// Adds what a finished bake came to.
    pub fn take(&mut self, ended: &Ended) {
        self.relative_error = Some(ended.error.0);
        self.relative_error_se = Some(ended.error.1);
        self.cells = Some(ended.cells);
        self.target_met = Some(ended.met);
        self.rounds = Some(ended.rounds);
        self.stop = Some(ended.stop.clone());
    }

    /// Adds what the files of the run tell; nothing where they cannot be read.
    pub fn measure(&mut self) {
        self.bytes = Some(folder_bytes(&self.run));
        self.model_bytes = Some(folder_bytes(&self.run.join("model")));
        let Ok(run) = Run::open(&self.run) else {
            return;
        };
        let (mut work, mut forecast) = (0.0, 0.0);
        for round in 0.. {
            let Ok(Some(plan)) = run.read_plan(round) else {
                break;
            };
            let timings = run.read_timings(round).ok().flatten();
            work += timings.map_or(0.0, |timings| timings.total());
            let tasks = run.tasks(&plan).unwrap_or_default();
            forecast += tasks.iter().map(|task| task.seconds).sum::<f64>();
        }
        self.work_seconds = Some(work);
        self.forecast_core_seconds = Some(forecast);
    }
}

/// `summary.json`.
#[derive(Debug, Serialize)]
pub struct Summary<'a> {
    /// Program and version.
    pub version: String,
    /// The batch file.
    pub batch: &'a Path,
    /// When the command began, UTC.
    pub started: String,
    /// Wall time so far \[s\].
    pub seconds: f64,
    /// Whether runs are still to come: the command is at work, or was killed.
    pub unfinished: bool,
    /// The exit code; none while runs are to come.
    pub code: Option<u8>,
    /// The runs, in the order of the file.
    pub runs: &'a [Outcome],
}

/// The exit code of a batch: 1 where trying again may help, then 2, then 3.
pub fn worst(outcomes: &[Outcome]) -> u8 {
    let has = |code: &u8| outcomes.iter().any(|outcome| outcome.code == *code);
    [1, 2, 3].into_iter().find(has).unwrap_or(0)
}

/// Bytes of all files below a folder; what cannot be read counts nothing.
fn folder_bytes(folder: &Path) -> u64 {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return 0;
    };
    let bytes = entries.flatten().map(|entry| match entry.file_type() {
        Ok(kind) if kind.is_dir() => folder_bytes(&entry.path()),
        Ok(kind) if kind.is_file() => entry.metadata().map_or(0, |found| found.len()),
        _ => 0,
    });
    bytes.sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_may_help_to_try_again_goes_first() {
        let of = |codes: &[u8]| {
            let outcome = |&code: &u8| {
                let state = (code, State::Failed);
                Outcome::without_work("run".into(), "scene".into(), state, String::new())
            };
            worst(&codes.iter().map(outcome).collect::<Vec<_>>())
        };
        assert_eq!(of(&[]), 0);
        assert_eq!(of(&[0, 0]), 0);
        assert_eq!(of(&[0, 3, 0]), 3);
        assert_eq!(of(&[3, 2, 0]), 2);
        assert_eq!(of(&[2, 3, 1]), 1);
    }
}
