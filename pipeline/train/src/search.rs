//! Many starts, few finishes: successive halving of the starts while the rows double.
//!
//! Tiny nets from different first weights end up to a factor of two apart, and early errors on
//! few rows foretell late ones on many well enough to drop the worse half at each rung
//! (Jamieson, Talwalkar 2016). A rung of half the nets on twice the rows costs as much as the
//! one before.

use crate::cell::Cell;
use crate::config::{LADDER, TrainConfig};
use crate::descent::{Begin, Descent, Leg};
use crate::end::FitEnd;
use rrf_field::net::Shape;

/// Legs before the last, which runs on all rows: the share of the rows of each and how many
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
pub(crate) fn best_of_starts<'a>(cell: &'a Cell, shape: &Shape) -> Option<(Descent<'a>, FitEnd)> {
    let config = cell.config;
    if let Some(w) = cell.earlier_weights(shape) {
        let going_on = vec![Descent::going_on(cell, shape.clone(), w)];
        return finish(cell, going_on, config.patience_going_on);
    }
    let begins = match config.exponential {
        true => &[Begin::Mean, Begin::Logarithm][..],
        false => &[Begin::Mean][..],
    };
    let begin = |start| {
        let net = Descent::new(cell, shape.clone(), start);
        begins
            .iter()
            .map(move |&begin| net.clone().beginning(begin))
    };
    let mut field: Vec<Descent> = (0..config.starts.max(1) as u64).flat_map(begin).collect();
    let rungs = rungs(config, field.len(), cell.train.len(), shape.weights());
    for (share, survivors) in &rungs {
        keep_best(&mut field, *survivors);
        for descent in &mut field {
            descent.run(Leg {
                share: *share,
                steps: config.rung_steps,
                patience: config.rung_steps,
            });
        }
    }
    if !rungs.is_empty() {
        keep_best(&mut field, 1);
    }
    finish(cell, field, config.patience)
}

/// Climbs [`LADDER`] until a net's relative error is at most `target`; the best net of all
/// where none is. Two rungs in a row without a gain of [`WORTHWHILE`] end the climb.
pub(crate) fn smallest<'a>(cell: &'a Cell, target: f64) -> Option<(Descent<'a>, FitEnd)> {
    let mut best: Option<(Descent, FitEnd)> = None;
    let mut in_vain = 0;
    for hidden in LADDER {
        let (found, stop) = best_of_starts(cell, &cell.shape(hidden))?;
        if found.error <= target * target {
            return Some((found, FitEnd::Target));
        }
        let before = best.as_ref().map_or(f64::INFINITY, |(best, _)| best.error);
        in_vain = if found.error < before * WORTHWHILE {
            0
        } else {
            in_vain + 1
        };
        if found.error < before || best.is_none() {
            best = Some((found, stop));
        }
        if in_vain == 2 {
            break;
        }
    }
    best
}

/// Down [`LADDER`] from below `shape`, each net fitted anew, for as long as the squared error is at most
/// `limit`: the last that was.
pub(crate) fn smaller<'a>(
    cell: &'a Cell,
    shape: &Shape,
    limit: f64,
) -> Option<(Descent<'a>, FitEnd)> {
    let weights = shape.weights();
    (LADDER.iter().rev().map(|hidden| cell.shape(hidden)))
        .filter(|smaller| smaller.weights() < weights)
        .map_while(|smaller| best_of_starts(cell, &smaller).filter(|(net, _)| net.error <= limit))
        .last()
}

/// A squared error that this times the last is a gain.
const WORTHWHILE: f64 = 0.95;

/// Lowest errors first, ties by start; NaN last.
fn keep_best(field: &mut Vec<Descent>, survivors: usize) {
    field.sort_by(|a, b| a.error.total_cmp(&b.error).then(a.start.cmp(&b.start)));
    field.truncate(survivors);
}

/// Runs all that are left on all rows; the best of them.
fn finish<'a>(
    cell: &Cell,
    mut field: Vec<Descent<'a>>,
    patience: usize,
) -> Option<(Descent<'a>, FitEnd)> {
    let last = Leg {
        share: 1.0,
        steps: cell.config.iterations,
        patience,
    };
    let stops: Vec<FitEnd> = field.iter_mut().map(|descent| descent.run(last)).collect();
    field
        .into_iter()
        .zip(stops)
        .min_by(|(a, _), (b, _)| a.error.total_cmp(&b.error).then(a.start.cmp(&b.start)))
}
