//! After a round: the reason to stop, or the plan of the next round.
//!
//! Every cell that misses the target has possible refinements ([`crate::policy::actions`]): a split,
//! more rows or a larger net. The next round takes those of most predicted gain a second until the
//! whole should meet the target, or until they make up most of what could be gained. The other cells
//! are left alone.

use crate::error::BakeError;
use crate::plan::evaluation::{CellEvaluation, EvaluatedRound, Evaluation};
use crate::plan::next::Next;
use crate::plan::refinement::{Action, Refinement};
use crate::plan::round::{CellPlan, MAX_DRAW_ROWS, PartPlan, RoundPlan, draw_parts};
use crate::plan::stop::StopReason;
use crate::policy::gain::GainCalibration;
use crate::policy::tasks::{FitHashes, RunInputs};
use crate::policy::test_rows;
use crate::settings::BakeConfig;
use rrf_train::cut::Cut;
use std::collections::BTreeMap;

/// A round takes actions until they make up this share of what all of them should gain: the rest is
/// spread thinly over many cells, and better evaluated after the round.
const SHARE: f64 = 0.5;
/// Or until the whole should reach this share of the target, since predictions are rough.
const AIM: f64 = 0.95;

/// The reason to stop after a round, if any.
pub(crate) fn stop_reason(
    config: &BakeConfig,
    plan: &RoundPlan,
    evaluation: &Evaluation,
) -> Option<StopReason> {
    if plan.compresses.is_some() {
        plan.compresses
    } else if evaluation.meets(f64::from(config.target)) {
        Some(StopReason::Target)
    } else if evaluation.is_within_noise() {
        Some(StopReason::Noise)
    } else if plan.round + 1 >= config.rounds {
        Some(StopReason::Rounds)
    } else {
        None
    }
}

/// The cells that miss the target; all with a positive error where only the whole misses it.
pub(crate) fn missing_target<'a>(
    config: &BakeConfig,
    evaluation: &'a Evaluation,
) -> Vec<&'a CellEvaluation> {
    let target = f64::from(config.target).powi(2);
    let beyond = |limit: f64| -> Vec<&CellEvaluation> {
        let cells = evaluation.cells.iter();
        cells.filter(|c| c.square_error > limit).collect()
    };
    match beyond(target) {
        // held-out rows chose the weights and give smaller errors than test rows
        none if none.is_empty() => beyond(0.0),
        some => some,
    }
}

/// Refinements that the round before found for cells that it left alone, by cell.
pub(crate) fn still_valid(
    plan: &RoundPlan,
    before: Option<EvaluatedRound>,
) -> BTreeMap<u32, Vec<Refinement>> {
    let mut valid: BTreeMap<u32, Vec<Refinement>> = BTreeMap::new();
    for refinement in before.map(|round| round.refinements).unwrap_or_default() {
        let cell = plan.cells.get(refinement.cell as usize);
        if cell.is_some_and(|cell| cell.fitted < plan.round) {
            valid.entry(refinement.cell).or_default().push(refinement);
        }
    }
    valid
}

/// Plans the next round from all possible refinements. The round costs no more than `budget` core
/// seconds as predicted, or takes one action.
pub(crate) fn next_round(
    inputs: RunInputs,
    plan: &RoundPlan,
    evaluation: &Evaluation,
    possible: &[Refinement],
    gains: &GainCalibration,
    budget: Option<f64>,
) -> Result<Next, BakeError> {
    let config = inputs.config;
    let mut chosen = within(chosen(config, evaluation, possible, gains), budget);
    if chosen.is_empty() {
        return Ok(Next::Stop(StopReason::NothingToRefine));
    }
    let mut next = plan.next();
    let hashes = FitHashes::new(inputs, plan);
    chosen.sort_by_key(|r| r.cell);
    for refinement in &chosen {
        if let Some(cell) = plan.cells.get(refinement.cell as usize) {
            apply(&mut next, refinement, hashes.fit(cell)?);
        }
    }
    let (target, paths) = (f64::from(config.target), config.extract.paths);
    test_rows::keep_up(&mut next, paths, target, Some(evaluation));
    Ok(Next::Round(Box::new(next)))
}

/// An action and the squared error that it should remove from the whole.
type Gain<'a> = (f64, &'a Refinement);

/// The actions that the round takes: one a cell, those of most gain a second first.
fn chosen(
    config: &BakeConfig,
    evaluation: &Evaluation,
    possible: &[Refinement],
    gains: &GainCalibration,
) -> Vec<Refinement> {
    let mut room = (config.most_cells as usize).saturating_sub(evaluation.cells.len());
    let rate = |&(gain, refinement): &Gain| gain / refinement.seconds.max(f64::MIN_POSITIVE);
    let mut best: BTreeMap<u32, Gain> = BTreeMap::new();
    for refinement in possible {
        let found = (refinement.share - gains.left(refinement), refinement);
        let allowed = room > 0 || !matches!(refinement.action, Action::Split { .. });
        // the first of equals: a split
        let beaten = best
            .get(&refinement.cell)
            .is_none_or(|b| rate(&found) > rate(b));
        if found.0 > 0.0 && allowed && beaten {
            best.insert(refinement.cell, found);
        }
    }
    let mut best: Vec<Gain> = best.into_values().collect();
    best.sort_by(|a, b| rate(b).total_cmp(&rate(a)).then(a.1.cell.cmp(&b.1.cell)));
    let possible: f64 = best.iter().map(|(gain, _)| gain).sum();
    let (error, se) = evaluation.error();
    let sought = AIM * f64::from(config.target).min(error);
    let wanted = (SHARE * possible).min((error + se).powi(2) - sought.powi(2));
    let mut gained = 0.0;
    let mut taken = Vec::new();
    for (gain, refinement) in best {
        if gained >= wanted {
            break;
        }
        if matches!(refinement.action, Action::Split { .. }) {
            if room == 0 {
                continue;
            }
            room -= 1;
        }
        gained += gain;
        taken.push(refinement.clone());
    }
    taken
}

/// The first actions that a budget allows, at least one.
fn within(mut chosen: Vec<Refinement>, budget: Option<f64>) -> Vec<Refinement> {
    let mut seconds = 0.0;
    let fits = |r: &&Refinement| {
        seconds += r.seconds;
        budget.is_none_or(|budget| seconds <= budget)
    };
    let count = chosen.iter().take_while(fits).count();
    chosen.truncate(count.max(1));
    chosen
}

/// Writes an action into the next round's plan; `fit` is the hash of the cell's fit so far.
fn apply(next: &mut RoundPlan, refinement: &Refinement, fit: String) {
    let Some(old) = next.cells.get(refinement.cell as usize).cloned() else {
        return;
    };
    let mut cell = CellPlan {
        fitted: next.round,
        earlier: Some(old.as_earlier(fit)),
        ..old
    };
    match &refinement.action {
        Action::Split { cut, left, .. } => return split(next, &cell, refinement, cut, *left),
        Action::MoreRows => {
            let leaf = next.tree.leaves()[cell.cell as usize];
            draw(next, &mut cell, leaf, refinement.rows, refinement.paths);
        }
        Action::LargerNet(size) => cell.size = size.clone(),
    }
    replace(next, cell);
}

fn replace(next: &mut RoundPlan, cell: CellPlan) {
    let id = cell.cell as usize;
    next.cells[id] = cell;
}

/// Replaces a cell by two; each draws the other's share of rows anew.
fn split(next: &mut RoundPlan, old: &CellPlan, refinement: &Refinement, cut: &Cut, left: f64) {
    let new = next.cells.len() as u32;
    let leaf = next.tree.leaves()[old.cell as usize];
    let nodes = next.tree.split(leaf, cut.axis, cut.threshold, new);
    let shares = [left, 1.0 - left];
    for ((id, share), node) in [old.cell, new].into_iter().zip(shares).zip(nodes) {
        let mut cell = CellPlan {
            cell: id,
            measure: old.measure * share,
            parts: taken(old, id),
            prune: None,
            ..old.clone()
        };
        let rows = (f64::from(refinement.rows) * (1.0 - share)).round() as u32;
        draw(next, &mut cell, node, rows, refinement.paths);
        if id == new {
            next.cells.push(cell);
        } else {
            replace(next, cell);
        }
    }
}

/// New draws for a cell, in its leaf.
fn draw(next: &mut RoundPlan, cell: &mut CellPlan, leaf: usize, rows: u32, paths: u32) {
    let first = cell.parts.iter().map(|p| p.part + 1).max().unwrap_or(0);
    if rows > 0 {
        let draws = &mut next.draws;
        let drawn = draw_parts(draws, leaf as u32, rows, paths, first, MAX_DRAW_ROWS);
        cell.parts.extend(drawn);
    }
}

/// The parts of a child, one for each of its parent's. The child that keeps the parent's id gets new
/// numbers, because the parent's files stay until the round is done.
fn taken(parent: &CellPlan, child: u32) -> Vec<PartPlan> {
    let last = parent.parts.iter().map(|p| p.part).max();
    let first = match (child == parent.cell, last) {
        (true, Some(last)) => last + 1,
        _ => 0,
    };
    (first..)
        .zip(&parent.parts)
        .map(|(part, old)| PartPlan {
            part,
            draw: old.draw,
            from: Some([parent.cell, old.part]),
        })
        .collect()
}

#[cfg(test)]
mod tests;
