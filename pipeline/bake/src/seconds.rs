//! `rounds/RRR/seconds.json`: the wall time of a round's stages, for people. It is the one file
//! in which two runs of one seed differ, and nothing that a bake decides depends on it, but for how
//! much of the last round fits into a time limit.

use crate::cost;
use crate::error::BakeError;
use crate::plan::RoundPlan;
use crate::run::{Run, read_json, write_json};
use crate::task::{Stage, expected_rows};
use rrf_store::layout::round_folder;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Wall time of a round's stages on one machine [s]. Stages that were cut off and went on add up;
/// the time of a process that was killed is in none, nor is that of tasks that others did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Seconds {
    /// Sampling.
    pub extract: f64,
    /// Fitting.
    pub train: f64,
    /// Making the model of the fits, judging it and planning the round after.
    pub judge: f64,
}

impl Seconds {
    /// All stages together.
    pub fn total(&self) -> f64 {
        self.extract + self.train + self.judge
    }
}

/// What a round took, or none where nobody wrote it down.
///
/// # Errors
/// [`BakeError::Store`].
pub fn read_seconds(run: &Run, round: u32) -> Result<Option<Seconds>, BakeError> {
    read_json(&path(run, round))
}

/// Puts down what a round took after all, where that was known.
pub(crate) fn put(run: &Run, round: u32, took: Option<Seconds>) -> Result<(), BakeError> {
    match took {
        Some(took) => write_json(&path(run, round), &took),
        None => Ok(()),
    }
}

/// The place of a stage's time.
pub(crate) fn of(stage: Stage) -> fn(&mut Seconds) -> &mut f64 {
    match stage {
        Stage::Extract => |s| &mut s.extract,
        Stage::Train => |s| &mut s.train,
    }
}

/// Adds the time since `start` to one of a round's stages.
pub(crate) fn add(
    run: &Run,
    round: u32,
    stage: fn(&mut Seconds) -> &mut f64,
    start: Instant,
) -> Result<(), BakeError> {
    if !run.is_there() {
        return Ok(());
    }
    // for people: what cannot be read begins anew
    let mut seconds = read_seconds(run, round).ok().flatten().unwrap_or_default();
    *stage(&mut seconds) += start.elapsed().as_secs_f64();
    write_json(&path(run, round), &seconds)
}

/// Share of the time left that a round is to take: predictions are rough.
const CAREFUL: f64 = 0.92;

/// What the next round may cost, in the seconds that tasks are said to take, if it takes as long for
/// each of them as this round did; none where this round's time is not known.
pub(crate) fn budget(
    run: &Run,
    plan: &RoundPlan,
    left: Duration,
) -> Result<Option<f64>, BakeError> {
    let took = read_seconds(run, plan.round).ok().flatten();
    let Some(took) = took.filter(|t| t.extract + t.train > 0.0) else {
        return Ok(None);
    };
    let before = match plan.round.checked_sub(1) {
        Some(before) => run.read_plan(before)?.map_or(0, |p| p.draws.len()),
        None => 0,
    };
    let draws = plan.draws.iter().skip(before);
    let drawn: f64 = draws
        .map(|d| cost::draw_seconds(d.rows, d.paths, plan.path_seconds))
        .sum();
    let fitted = plan.cells.iter().zip(expected_rows(plan));
    let fitted = fitted.filter(|(cell, _)| cell.fitted == plan.round);
    let trained: f64 = fitted
        .map(|(cell, rows)| cost::fit_seconds(rows, cell, &run.config.train))
        .sum();
    Ok(Some(affordable(drawn + trained, &took, left)))
}

/// What fits into the time left where `said` seconds took as long as they did.
fn affordable(said: f64, took: &Seconds, left: Duration) -> f64 {
    said * CAREFUL * left.as_secs_f64() / (took.extract + took.train)
}

/// Where the file lies.
pub(crate) fn path(run: &Run, round: u32) -> PathBuf {
    round_folder(&run.folder, round).join("seconds.json")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten seconds said that took five: in the 20 left, 40 of them but for the margin.
    #[test]
    fn a_round_is_measured_by_the_one_before() {
        let took = Seconds {
            extract: 4.0,
            train: 1.0,
            judge: 7.0,
        };
        let fits = affordable(10.0, &took, Duration::from_secs(20));
        assert!((fits - CAREFUL * 40.0).abs() < 1e-12, "{fits}");
        assert_eq!(affordable(10.0, &took, Duration::ZERO), 0.0);
    }
}
