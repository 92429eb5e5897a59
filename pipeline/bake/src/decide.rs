//! After a round: stop, or what the next one does.
//!
//! Every cell that misses the target has a remedy ([`crate::remedy`]): a split, more rows, or a
//! larger net, whichever promises most error removed a second. The next round takes the best of
//! them until the whole should meet the target or they make up most of what could be gained;
//! the other cells are left alone.

use crate::config::BakeConfig;
use crate::error::BakeError;
use crate::experience::Experience;
use crate::job::{Boxes, Shared};
use crate::judge::{CellJudgement, Judgement};
use crate::plan::{CellPlan, Earlier, MOST_ROWS, PartPlan, RoundPlan, draw_parts};
use crate::remedy::{Action, Remedy, remedies_of};
use crate::run::Run;
use crate::task::cell_hashes;
use crate::test_rows;
use crate::trim::trimming;
use rayon::prelude::*;
use rrf_train::cut::Cut;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Why no further round is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stop {
    /// The whole meets the target.
    Target,
    /// As many rounds as allowed.
    Rounds,
    /// Nothing is left to do about any cell.
    NothingToSplit,
    /// The error cannot be told from zero.
    Noise,
    /// The time limit.
    Time,
}

impl Stop {
    /// In words.
    pub fn text(self) -> &'static str {
        match self {
            Stop::Target => "the target is reached",
            Stop::Rounds => "all rounds that it may take are done",
            Stop::NothingToSplit => "nothing is left that would help a cell",
            Stop::Noise => "the noise of the samples hides the error that is left",
            Stop::Time => "the time limit is reached",
        }
    }
}

/// What comes after a round.
#[derive(Clone, Debug)]
pub enum Next {
    /// Another round.
    Round(Box<RoundPlan>),
    /// The end.
    Stop(Stop),
}

/// A round takes remedies until they make up this share of what all of them should remove:
/// the rest is spread thinly over many cells, and better judged after the round.
const SHARE: f64 = 0.5;
/// Or until the whole should come to this share of the target: predictions are rough.
const AIM: f64 = 0.95;

/// Decides from files of the run alone, so that a resumed run decides the same; but the last round
/// before a time limit takes no more than `budget`, in seconds as remedies count them, or one remedy. Gives the
/// remedies of all cells that miss the target as well: those of cells that are left alone are good for
/// the round after.
pub fn decide(
    run: &Run,
    plan: &RoundPlan,
    judgement: &Judgement,
    budget: Option<f64>,
) -> Result<(Next, Vec<Remedy>), BakeError> {
    if let Some(stop) = stop(&run.config, plan, judgement) {
        let next = match trimming(run, plan, judgement, stop, budget)? {
            Some(next) => Next::Round(Box::new(next)),
            None => Next::Stop(stop),
        };
        return Ok((next, Vec::new()));
    }
    let (target, paths) = (f64::from(run.config.target), run.config.extract.paths);
    // not in place of the last round that could help a cell
    let rounds_left = plan.round + 2 < run.config.rounds;
    let more = || test_rows::more(plan, paths, target, judgement);
    if let Some(next) = rounds_left.then(more).flatten() {
        let known = known(run, plan)?.into_values().flatten();
        return Ok((Next::Round(Box::new(next)), known.collect()));
    }
    let possible = remedies(run, plan, judgement)?;
    let experience = Experience::of(run, plan, &judgement.cells)?;
    let remedies = chosen(&run.config, judgement, &possible, &experience);
    let mut remedies = within(remedies, budget);
    if remedies.is_empty() {
        return Ok((Next::Stop(Stop::NothingToSplit), possible));
    }
    let mut next = RoundPlan {
        round: plan.round + 1,
        ..plan.clone()
    };
    let (boxes, shared) = (Boxes::new(&plan.tree), Shared::of(plan));
    remedies.sort_by_key(|r| r.cell);
    for remedy in &remedies {
        if let Some(cell) = plan.cells.get(remedy.cell as usize) {
            let (_, fit) = cell_hashes(run, &shared, &boxes.of_cell(plan, cell)?)?;
            apply(&mut next, remedy, fit);
        }
    }
    test_rows::keep_up(&mut next, paths, target, Some(judgement));
    Ok((Next::Round(Box::new(next)), possible))
}

fn stop(config: &BakeConfig, plan: &RoundPlan, judgement: &Judgement) -> Option<Stop> {
    if plan.trims.is_some() {
        plan.trims
    } else if judgement.meets(f64::from(config.target)) {
        Some(Stop::Target)
    } else if judgement.hidden() {
        Some(Stop::Noise)
    } else if plan.round + 1 >= config.rounds {
        Some(Stop::Rounds)
    } else {
        None
    }
}

/// All that could be done about the cells that miss the target, or about all that err where only the whole
/// does; of cells that the round before left alone, what it found.
fn remedies(run: &Run, plan: &RoundPlan, judgement: &Judgement) -> Result<Vec<Remedy>, BakeError> {
    let target = f64::from(run.config.target).powi(2);
    let beyond = |limit: f64| -> Vec<&CellJudgement> {
        let cells = judgement.cells.iter();
        cells.filter(|c| c.square_error > limit).collect()
    };
    let misses = match beyond(target) {
        // rows held out are kinder than test rows
        none if none.is_empty() => beyond(0.0),
        some => some,
    };
    let known = known(run, plan)?;
    let found = misses
        .into_par_iter()
        .map(|judged| match plan.cells.get(judged.cell as usize) {
            Some(cell) => match known.get(&cell.cell) {
                Some(remedies) => Ok(remedies.clone()),
                None => remedies_of(run, plan, cell, judged),
            },
            None => Ok(Vec::new()),
        })
        .collect::<Result<Vec<Vec<Remedy>>, BakeError>>()?;
    Ok(found.into_iter().flatten().collect())
}

/// Remedies that the round before found for cells that it left alone.
fn known(run: &Run, plan: &RoundPlan) -> Result<BTreeMap<u32, Vec<Remedy>>, BakeError> {
    let before = match plan.round.checked_sub(1) {
        Some(before) => run.read_judged(before)?,
        None => None,
    };
    let mut known: BTreeMap<u32, Vec<Remedy>> = BTreeMap::new();
    for remedy in before.map(|judged| judged.remedies).unwrap_or_default() {
        let cell = plan.cells.get(remedy.cell as usize);
        if cell.is_some_and(|cell| cell.fitted < plan.round) {
            known.entry(remedy.cell).or_default().push(remedy);
        }
    }
    Ok(known)
}

/// A remedy and the squared error that it should remove from the whole.
type Gain<'a> = (f64, &'a Remedy);

/// The remedies that the round takes: one a cell, those of most gain a second first.
fn chosen(
    config: &BakeConfig,
    judgement: &Judgement,
    remedies: &[Remedy],
    experience: &Experience,
) -> Vec<Remedy> {
    let mut room = (config.most_cells as usize).saturating_sub(judgement.cells.len());
    let rate = |&(gain, remedy): &Gain| gain / remedy.seconds.max(f64::MIN_POSITIVE);
    let mut best: BTreeMap<u32, Gain> = BTreeMap::new();
    for remedy in remedies {
        let found = (remedy.share - experience.left(remedy), remedy);
        let allowed = room > 0 || !matches!(remedy.action, Action::Split { .. });
        // the first of equals: a split
        let beaten = best
            .get(&remedy.cell)
            .is_none_or(|b| rate(&found) > rate(b));
        if found.0 > 0.0 && allowed && beaten {
            best.insert(remedy.cell, found);
        }
    }
    let mut best: Vec<Gain> = best.into_values().collect();
    best.sort_by(|a, b| rate(b).total_cmp(&rate(a)).then(a.1.cell.cmp(&b.1.cell)));
    let possible: f64 = best.iter().map(|(gain, _)| gain).sum();
    let (error, se) = judgement.error();
    let sought = AIM * f64::from(config.target).min(error);
    let wanted = (SHARE * possible).min((error + se).powi(2) - sought.powi(2));
    let mut gained = 0.0;
    let mut taken = Vec::new();
    for (gain, remedy) in best {
        if gained >= wanted {
            break;
        }
        if matches!(remedy.action, Action::Split { .. }) {
            if room == 0 {
                continue;
            }
            room -= 1;
        }
        gained += gain;
        taken.push(remedy.clone());
    }
    taken
}

/// The first remedies that a budget allows, at least one.
fn within(mut remedies: Vec<Remedy>, budget: Option<f64>) -> Vec<Remedy> {
    let mut spent = 0.0;
    let fits = |r: &&Remedy| {
        spent += r.seconds;
        budget.is_none_or(|budget| spent <= budget)
    };
    let count = remedies.iter().take_while(fits).count();
    remedies.truncate(count.max(1));
    remedies
}

/// Writes a remedy into the next round's plan; `fit` is the hash of the cell's fit so far.
fn apply(next: &mut RoundPlan, remedy: &Remedy, fit: String) {
    let Some(old) = next.cells.get(remedy.cell as usize).cloned() else {
        return;
    };
    match &remedy.action {
        Action::Split { cut, left, .. } => split(next, &old, remedy, cut, *left, fit),
        Action::More => {
            let leaf = next.tree.leaves()[old.cell as usize];
            let mut cell = CellPlan {
                fitted: next.round,
                earlier: Some(earlier(&old, fit)),
                ..old
            };
            draw(next, &mut cell, leaf, remedy.rows, remedy.paths);
            replace(next, cell);
        }
        Action::Grow(size) => {
            let cell = CellPlan {
                size: size.clone(),
                fitted: next.round,
                earlier: Some(earlier(&old, fit)),
                ..old
            };
            replace(next, cell);
        }
    }
}

/// What goes on from a cell's fit.
pub(crate) fn earlier(cell: &CellPlan, task: String) -> Earlier {
    Earlier {
        round: cell.fitted,
        cell: cell.cell,
        task,
    }
}

fn replace(next: &mut RoundPlan, cell: CellPlan) {
    let id = cell.cell as usize;
    next.cells[id] = cell;
}

/// Two cells in place of one; each gets the other's share of rows anew.
fn split(next: &mut RoundPlan, old: &CellPlan, remedy: &Remedy, cut: &Cut, left: f64, fit: String) {
    let new = next.cells.len() as u32;
    let leaf = next.tree.leaves()[old.cell as usize];
    let nodes = next.tree.split(leaf, cut.axis, cut.threshold, new);
    let shares = [left, 1.0 - left];
    for ((id, share), node) in [old.cell, new].into_iter().zip(shares).zip(nodes) {
        let mut cell = CellPlan {
            cell: id,
            measure: old.measure * share,
            parts: taken(old, id),
            size: old.size.clone(),
            fitted: next.round,
            earlier: Some(earlier(old, fit.clone())),
            prune: None,
        };
        let rows = (f64::from(remedy.rows) * (1.0 - share)).round() as u32;
        draw(next, &mut cell, node, rows, remedy.paths);
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
        let drawn = draw_parts(&mut next.draws, leaf as u32, rows, paths, first, MOST_ROWS);
        cell.parts.extend(drawn);
    }
}

/// A child's parts: one for each of its parent's. The child that keeps the parent's id gets new
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
