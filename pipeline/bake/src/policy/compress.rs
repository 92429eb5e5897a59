//! The compression pass, which is the last round of a bake that meets its target: smaller nets replace
//! larger ones, and inputs and units that are not needed are removed (`rrf_train`'s pruning), for as
//! long as the whole model still meets the target.
//!
//! With E² the squared error of the whole, E its standard error σ and T the target, nets may lose
//! accuracy until A (1 + σ / E) = T. Each cell may add A² − E² to its own squared error, so that all of
//! them together add as much to that of the whole. The pass may take no more than [`SHARE`] of the time
//! of all samples and fits.

use crate::error::BakeError;
use crate::plan::evaluation::Evaluation;
use crate::plan::round::RoundPlan;
use crate::plan::stop::StopReason;
use crate::policy::cost;
use crate::policy::tasks::{FitHashes, RunInputs, expected_rows};
use crate::settings::BakeConfig;
use std::collections::BTreeMap;

/// Maximum predicted time, as a share of that of all samples so far and one fit of each cell.
const SHARE: f64 = 0.5;

/// Predicted time that may be planned relative to the time left: where nets give little the pass takes
/// two fifths of the prediction, and the time limit keeps what is done of it.
const HOPEFUL: f64 = 2.0;

/// Plans the pass; none where there is nothing to lose or no time.
pub(crate) fn compression_pass(
    inputs: RunInputs,
    plan: &RoundPlan,
    evaluation: &Evaluation,
    stop: StopReason,
    budget: Option<f64>,
) -> Result<Option<RoundPlan>, BakeError> {
    let config = inputs.config;
    let last = plan.round + 1 >= config.rounds;
    if !config.compress || stop != StopReason::Target || plan.compresses.is_some() || last {
        return Ok(None);
    }
    let slack = slack(evaluation, f64::from(config.target));
    let rows = expected_rows(plan);
    let most = SHARE * seconds_again(config, plan, &rows);
    let most = budget.map_or(most, |budget| most.min(HOPEFUL * budget));
    // the largest nets first, where time is short
    let mut cells: Vec<_> = evaluation.cells.iter().collect();
    cells.sort_by(|a, b| b.weights.cmp(&a.weights).then(a.cell.cmp(&b.cell)));
    let mut next = RoundPlan {
        compresses: Some(stop),
        ..plan.next()
    };
    let hashes = FitHashes::new(inputs, plan);
    let (mut seconds, mut some) = (0.0, false);
    for evaluated in cells {
        let id = evaluated.cell as usize;
        let (Some(cell), Some(&rows)) = (next.cells.get_mut(id), rows.get(id)) else {
            continue;
        };
        let Some(share) = share(evaluated.square_error, slack) else {
            continue;
        };
        seconds += cost::prune_seconds(rows, u64::from(evaluated.weights));
        if seconds > most {
            break;
        }
        cell.earlier = Some(cell.as_earlier(hashes.fit(cell)?));
        cell.fitted = next.round;
        cell.prune = Some(share);
        some = true;
    }
    Ok(some.then_some(next))
}

/// The plan of a pass in which half of its cells keep their earlier fits, those whose error grew most,
/// where the whole does not meet the target any more. None where it does, or where no cell is left to
/// restore. `before` is the plan and evaluation of the round before.
pub(crate) fn restore_worst(
    config: &BakeConfig,
    plan: &RoundPlan,
    evaluation: &Evaluation,
    before: (&RoundPlan, &Evaluation),
) -> Option<RoundPlan> {
    let compresses = plan.compresses == Some(StopReason::Target);
    if !compresses || evaluation.meets(f64::from(config.target)) {
        return None;
    }
    let grown = grown(plan, before.1, evaluation);
    let worst = &grown[..grown.len().div_ceil(2)];
    (!worst.is_empty()).then(|| restored(plan, before.0, worst))
}

/// The cells that the round fitted, those that added most to the squared error of the whole first.
fn grown(plan: &RoundPlan, before: &Evaluation, after: &Evaluation) -> Vec<u32> {
    let was: BTreeMap<u32, f64> = (before.cells.iter())
        .map(|c| (c.cell, c.square_error))
        .collect();
    let fitted = |cell: u32| {
        let planned = plan.cells.get(cell as usize);
        planned.is_some_and(|c| c.fitted == plan.round)
    };
    let mut grown: Vec<(f64, u32)> = (after.cells.iter())
        .filter(|c| fitted(c.cell))
        .map(|c| {
            let was = was.get(&c.cell).copied().unwrap_or(0.0);
            (c.measure * (c.square_error - was), c.cell)
        })
        .collect();
    grown.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    grown.into_iter().map(|(_, cell)| cell).collect()
}

/// The plan of a round in which some cells keep the fits of the round before.
pub(crate) fn restored(plan: &RoundPlan, before: &RoundPlan, cells: &[u32]) -> RoundPlan {
    let mut restored = plan.clone();
    for &cell in cells {
        let cell = cell as usize;
        if let (Some(cell), Some(old)) = (restored.cells.get_mut(cell), before.cells.get(cell)) {
            cell.clone_from(old);
        }
    }
    restored
}

/// Predicted seconds of one core for all samples and a first fit of each cell.
fn seconds_again(config: &BakeConfig, plan: &RoundPlan, rows: &[u64]) -> f64 {
    let drawn = plan.draws.iter();
    let drawn = drawn.map(|d| cost::draw_seconds(d.rows, d.paths, plan.path_seconds));
    let fitted = plan.cells.iter().zip(rows);
    let fitted = fitted.map(|(c, &rows)| cost::train_seconds(rows, &c.size, &config.train, false));
    drawn.sum::<f64>() + fitted.sum::<f64>()
}

/// A² − E².
fn slack(evaluation: &Evaluation, target: f64) -> f64 {
    let (error, se) = evaluation.error();
    if error <= 0.0 {
        return 0.0;
    }
    let allowed = target / (1.0 + se / error);
    (allowed * allowed - error * error).max(0.0)
}

/// The share by which a cell's error may grow; none where its rows cannot tell it from zero.
fn share(square_error: f64, slack: f64) -> Option<f64> {
    (square_error > 0.0).then(|| (1.0 + slack / square_error).sqrt() - 1.0)
}

#[cfg(test)]
mod tests;
