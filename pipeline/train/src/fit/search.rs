//! Many starts, few finishes: successive halving of the starts while the rows double.
//!
//! Tiny nets from different first weights end up to a factor of two apart, and early errors on
//! few rows foretell late ones on many well enough to drop the worse half at each rung
//! (Jamieson, Talwalkar 2016). A rung of half the nets on twice the rows costs as much as the
//! one before.

use super::initialization::Initialization;
use super::optimizer::{OptimizerRun, Phase};
use super::warm;
use crate::cell::Cell;
use crate::config::{ARCHITECTURES, TrainConfig};
use crate::end::FitEnd;
use rrf_field::net::Shape;

/// Phases before the last, which runs on all rows: the share of the rows of each and how many
/// nets run it.
fn rungs(config: &TrainConfig, most: usize, rows: usize, weights: usize) -> Vec<(f64, usize)> {
    let mut rungs = Vec::new();
    let (mut share, mut starts) = (0.5, 1);
    for _ in 0..config.rungs {
        // Fewer residuals than a few times the weights teach nothing about the whole.
        if (rows as f64 * share) < LEAST_ROWS * weights as f64 {
            break;
        }
        rungs.push((share, starts));
        (share, starts) = (share * 0.5, (starts * 2).min(most));
    }
    rungs.reverse();
    // Where rows allow fewer rungs than halvings, the first one halves more than once.
    if let Some(first) = rungs.first_mut() {
        first.1 = most;
    }
    rungs
}

/// Rows a weight that a rung has at the least.
const LEAST_ROWS: f64 = 3.0;

/// The best net of a shape that the configuration's starts lead to.
pub(crate) fn best_of_starts<'a>(cell: &'a Cell, shape: &Shape) -> Option<OptimizerRun<'a>> {
    let config = cell.config;
    if let Some(w) = warm::earlier_weights(cell, shape) {
        let how = Initialization::Fitted;
        let run = OptimizerRun::new(cell, shape.clone(), w, how, config.lm);
        return best_of(vec![run], last_phase(config, config.patience_going_on));
    }
    let ways = match config.exponential {
        true => &[Initialization::Mean, Initialization::Logarithm][..],
        false => &[Initialization::Mean][..],
    };
    let starts = 0..config.starts.max(1) as u64;
    let mut runs: Vec<OptimizerRun> = starts
        .flat_map(|start| ways.iter().map(move |&how| (start, how)))
        .map(|(start, how)| OptimizerRun::random(cell, shape, start, how))
        .collect();
    let rungs = rungs(config, runs.len(), cell.train.len(), shape.weights());
    for (share, survivors) in &rungs {
        keep_best(&mut runs, *survivors);
        for run in &mut runs {
            run.run(Phase {
                share: *share,
                steps: config.rung_steps,
                patience: config.rung_steps,
            });
        }
    }
    if !rungs.is_empty() {
        keep_best(&mut runs, 1);
    }
    best_of(runs, last_phase(config, config.patience))
}

/// Climbs [`ARCHITECTURES`] until a net's relative error is at most `target`; the best net of all
/// where none is. Two in a row without a gain of [`WORTHWHILE`] end the climb.
pub(crate) fn smallest<'a>(cell: &'a Cell, target: f64) -> Option<OptimizerRun<'a>> {
    let mut best: Option<OptimizerRun> = None;
    let mut in_vain = 0;
    for hidden in ARCHITECTURES {
        let mut found = best_of_starts(cell, &cell.shape(hidden))?;
        if found.error <= target * target {
            found.end = FitEnd::Target;
            return Some(found);
        }
        let before = best.as_ref().map_or(f64::INFINITY, |best| best.error);
        in_vain = if found.error < before * WORTHWHILE {
            0
        } else {
            in_vain + 1
        };
        if found.error < before || best.is_none() {
            best = Some(found);
        }
        if in_vain == 2 {
            break;
        }
    }
    best
}

/// Down [`ARCHITECTURES`] from below `shape`, each net fitted anew, for as long as the squared error is
/// at most `limit`: the last that was.
pub(crate) fn smaller<'a>(cell: &'a Cell, shape: &Shape, limit: f64) -> Option<OptimizerRun<'a>> {
    let weights = shape.weights();
    (ARCHITECTURES.iter().rev().map(|hidden| cell.shape(hidden)))
        .filter(|smaller| smaller.weights() < weights)
        .map_while(|smaller| best_of_starts(cell, &smaller).filter(|run| run.error <= limit))
        .last()
}

/// A squared error that this times the last is a gain.
const WORTHWHILE: f64 = 0.95;

/// Lowest errors first, ties by start; NaN last.
fn keep_best(runs: &mut Vec<OptimizerRun>, survivors: usize) {
    runs.sort_by(|a, b| a.error.total_cmp(&b.error).then(a.start.cmp(&b.start)));
    runs.truncate(survivors);
}

/// A phase on all rows.
fn last_phase(config: &TrainConfig, patience: usize) -> Phase {
    Phase {
        share: 1.0,
        steps: config.iterations,
        patience,
    }
}

/// Runs all that are left through a last phase; the best of them.
fn best_of(mut runs: Vec<OptimizerRun>, phase: Phase) -> Option<OptimizerRun> {
    runs.iter_mut().for_each(|run| run.run(phase));
    runs.into_iter()
        .min_by(|a, b| a.error.total_cmp(&b.error).then(a.start.cmp(&b.start)))
}
