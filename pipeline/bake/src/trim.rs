//! The last round of a bake that has met its target: nets make way for smaller ones, and inputs and units that
//! they can do without go (`rrf_train`'s pruning), on the rows that there are, for as long as the whole still
//! meets the target.
//!
//! With E² the squared error of the whole, E its standard error σ and T the target, nets may lose until
//! A (1 + σ / E) = T. Each cell may add A² − E² to its own squared error, so that all of them add that
//! to the whole's. It is to take no more than [`SHARE`] of the time that the samples
//! took and fits to them would take.

use crate::config::BakeConfig;
use crate::cost;
use crate::decide::{Stop, earlier};
use crate::error::BakeError;
use crate::job::{Boxes, Shared};
use crate::judge::Judgement;
use crate::plan::RoundPlan;
use crate::run::Run;
use crate::seconds;
use crate::task::{Stage, cell_hashes, expected_rows, is_done, tasks};
use std::collections::BTreeMap;

/// Most time that it may take, as a share of what drawing all samples so far and a fit of each cell should take.
const SHARE: f64 = 0.5;

/// Times the time left that it may be said to take: where nets give little it takes two fifths of what is said,
/// and of a round that the time limit cuts off stays what is done.
const HOPEFUL: f64 = 2.0;

/// The round, or none where there is nothing to lose or no time.
pub(crate) fn trimming(
    run: &Run,
    plan: &RoundPlan,
    judgement: &Judgement,
    stop: Stop,
    budget: Option<f64>,
) -> Result<Option<RoundPlan>, BakeError> {
    let config = &run.config;
    let rounds_left = plan.round + 1 < config.rounds;
    if !config.trim || stop != Stop::Target || plan.trims.is_some() || !rounds_left {
        return Ok(None);
    }
    let slack = slack(judgement, f64::from(config.target));
    let rows = expected_rows(plan);
    let most = SHARE * anew(config, plan, &rows);
    let most = budget.map_or(most, |budget| most.min(HOPEFUL * budget));
    // the largest nets first, where time is short
    let mut cells: Vec<_> = judgement.cells.iter().collect();
    cells.sort_by(|a, b| b.weights.cmp(&a.weights).then(a.cell.cmp(&b.cell)));
    let mut next = RoundPlan {
        round: plan.round + 1,
        trims: Some(stop),
        ..plan.clone()
    };
    let (boxes, shared) = (Boxes::new(&plan.tree), Shared::of(plan));
    let (mut spent, mut some) = (0.0, false);
    for judged in cells {
        let id = judged.cell as usize;
        let (Some(cell), Some(&rows)) = (next.cells.get_mut(id), rows.get(id)) else {
            continue;
        };
        let Some(share) = share(judged.square_error, slack) else {
            continue;
        };
        spent += cost::prune_seconds(rows, u64::from(judged.weights));
        if spent > most {
            break;
        }
        let (_, fit) = cell_hashes(run, &shared, &boxes.of_cell(plan, cell)?)?;
        cell.earlier = Some(earlier(cell, fit));
        cell.fitted = next.round;
        cell.prune = Some(share);
        some = true;
    }
    Ok(some.then_some(next))
}

/// What a round that was cut off has come to, as its plan: the other cells keep the fits that they had. None
/// where it is no such round, or no fit is done.
pub(crate) fn trimmed_so_far(run: &Run, plan: &RoundPlan) -> Result<Option<RoundPlan>, BakeError> {
    let before = match (plan.trims, plan.round.checked_sub(1)) {
        (Some(_), Some(before)) => run.read_plan(before)?,
        _ => None,
    };
    let Some(before) = before else {
        return Ok(None);
    };
    let mut cut_off = Vec::new();
    for task in tasks(run, plan)? {
        if task.stage == Stage::Train && !is_done(run, &task)? {
            cut_off.push(task.cell);
        }
    }
    let so_far = as_before(plan, &before, &cut_off);
    let some = so_far.cells.iter().any(|c| c.fitted == plan.round);
    if some {
        rewrite(run, &so_far)?;
    }
    Ok(some.then_some(so_far))
}

/// The plan of a round that trims without half of its cells, those whose error grew most, where the whole does not
/// meet the target any more. None where it does, or nothing is left to take back.
pub(crate) fn taken_back(
    run: &Run,
    plan: &RoundPlan,
    judgement: &Judgement,
) -> Result<Option<RoundPlan>, BakeError> {
    let before = match (plan.trims, plan.round.checked_sub(1)) {
        (Some(Stop::Target), Some(before)) if !judgement.meets(f64::from(run.config.target)) => {
            before
        }
        _ => return Ok(None),
    };
    let (Some(before), Some(judged)) = (run.read_plan(before)?, run.read_judged(before)?) else {
        return Ok(None);
    };
    let grown = grown(plan, &judged.judgement, judgement);
    if grown.is_empty() {
        return Ok(None);
    }
    let fewer = as_before(plan, &before, &grown[..grown.len().div_ceil(2)]);
    rewrite(run, &fewer)?;
    Ok(Some(fewer))
}

/// Cells that the round fitted anew, those that added most to the squared error of the whole first.
fn grown(plan: &RoundPlan, before: &Judgement, after: &Judgement) -> Vec<u32> {
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

/// A plan in which some cells keep the fits that they had.
fn as_before(plan: &RoundPlan, before: &RoundPlan, cells: &[u32]) -> RoundPlan {
    let mut with = plan.clone();
    for &cell in cells {
        let cell = cell as usize;
        if let (Some(cell), Some(old)) = (with.cells.get_mut(cell), before.cells.get(cell)) {
            cell.clone_from(old);
        }
    }
    with
}

/// Writes another plan of a round, whose time so far still counts.
fn rewrite(run: &Run, plan: &RoundPlan) -> Result<(), BakeError> {
    let took = seconds::read_seconds(run, plan.round)?;
    run.write_plan(plan)?;
    seconds::put(run, plan.round, took)
}

/// Seconds of one core that all samples and a first fit of each cell to them should take.
fn anew(config: &BakeConfig, plan: &RoundPlan, rows: &[u64]) -> f64 {
    let drawn = plan.draws.iter();
    let drawn = drawn.map(|d| cost::draw_seconds(d.rows, d.paths, plan.path_seconds));
    let fitted = plan.cells.iter().zip(rows);
    let fitted = fitted.map(|(c, &rows)| cost::train_seconds(rows, &c.size, &config.train, false));
    drawn.sum::<f64>() + fitted.sum::<f64>()
}

/// A² − E².
fn slack(judgement: &Judgement, target: f64) -> f64 {
    let (error, se) = judgement.error();
    if error <= 0.0 {
        return 0.0;
    }
    let allowed = target / (1.0 + se / error);
    (allowed * allowed - error * error).max(0.0)
}

/// What a cell's error may grow by, as a share of it; none where rows cannot tell it from zero.
fn share(square_error: f64, slack: f64) -> Option<f64> {
    (square_error > 0.0).then(|| (1.0 + slack / square_error).sqrt() - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::judge::CellJudgement;
    use crate::plan::CellPlan;

    /// A cell taken back, those fitted in this round only, what weighs most first; the rest of the plan stays.
    #[test]
    fn the_costliest_are_taken_back_first() {
        let of = |squares: [f64; 4]| Judgement {
            relative_error: 0.0,
            relative_error_se: 0.0,
            test: None,
            cells: (0u32..)
                .zip(squares)
                .map(|(cell, square_error)| CellJudgement {
                    cell,
                    measure: [0.1, 0.2, 0.3, 0.4][cell as usize],
                    square_error,
                    square_error_se: 0.0,
                    train_square_error: 0.0,
                    noise: 0.0,
                    train_rows: 0,
                    effective_parameters: 0.0,
                    rows: 0,
                    weights: 0,
                })
                .collect(),
        };
        let mut before = crate::plan::one_cell(128);
        let cell = before.cells[0].clone();
        before.cells = (0..4)
            .map(|id| CellPlan {
                cell: id,
                ..cell.clone()
            })
            .collect();
        let mut plan = before.clone();
        plan.round = 3;
        for cell in &mut plan.cells[..3] {
            (cell.fitted, cell.prune) = (3, Some(0.1));
        }
        // grown by 0.05, 0.04 and 0.03 of the whole's square; the last was not fitted
        let grown = grown(&plan, &of([0.1; 4]), &of([0.6, 0.3, 0.2, 9.0]));
        assert_eq!(grown, [0, 1, 2]);
        let fewer = as_before(&plan, &before, &grown[..2]);
        assert_eq!(fewer.cells[..2], before.cells[..2]);
        assert_eq!(fewer.cells[2..], plan.cells[2..]);
        assert_eq!(fewer.round, 3);
    }

    /// Cells that lose all that they may bring the whole to where error and standard error, in
    /// proportion, meet the target.
    #[test]
    fn all_of_the_slack_is_shared_out() {
        let judgement = Judgement {
            relative_error: 0.04,
            relative_error_se: 0.002,
            test: None,
            cells: Vec::new(),
        };
        let slack = slack(&judgement, 0.05);
        let (measures, squares) = ([0.25, 0.75], [0.0004, 0.002]);
        let after: f64 = (measures.iter().zip(squares))
            .map(|(m, e)| m * e * (1.0 + share(e, slack).unwrap()).powi(2))
            .sum();
        let before: f64 = measures.iter().zip(squares).map(|(m, e)| m * e).sum();
        let error = (0.04f64.powi(2) + after - before).sqrt();
        assert!((error * (1.0 + 0.002 / 0.04) - 0.05).abs() < 1e-12);
        assert_eq!(share(-1e-5, slack), None);
    }
}
