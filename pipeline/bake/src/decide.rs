//! After a round: stop, or what the next one does.
//!
//! Cells that miss the target are split where their rows scatter most, the ones that add most
//! to the error of the whole first; cells that meet it are left alone.

use crate::config::BakeConfig;
use crate::error::BakeError;
use crate::judge::Judgement;
use crate::plan::{CellPlan, PartPlan, RoundPlan};
use crate::run::Run;
use crate::work::read_cell;
use rrf_extract::cut;
use serde::{Deserialize, Serialize};

/// Why no further round is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stop {
    /// The whole meets the target.
    Target,
    /// As many rounds as allowed.
    Rounds,
    /// No cell can be split any further.
    NothingToSplit,
    /// The time limit.
    Time,
}

impl Stop {
    /// In words.
    pub fn text(self) -> &'static str {
        match self {
            Stop::Target => "the target is reached",
            Stop::Rounds => "all rounds of the preset are done",
            Stop::NothingToSplit => "no cell has rows enough to be split",
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

/// Decides from the round's plan and judgement alone, so that a resumed run decides the same.
pub fn decide(run: &Run, plan: &RoundPlan, judgement: &Judgement) -> Result<Next, BakeError> {
    let config = &run.config;
    if judgement.relative_error <= f64::from(config.target) {
        return Ok(Next::Stop(Stop::Target));
    }
    if plan.round + 1 >= config.rounds {
        return Ok(Next::Stop(Stop::Rounds));
    }
    let mut next = RoundPlan {
        round: plan.round + 1,
        ..plan.clone()
    };
    for cell in worst(config, judgement) {
        split(run, plan, &mut next, cell)?;
    }
    Ok(match next.cells.len() > plan.cells.len() {
        true => Next::Round(Box::new(next)),
        false => Next::Stop(Stop::NothingToSplit),
    })
}

/// Cells to split: those that miss the target, by what they add to the whole, at most as many
/// as there are cells already and the limit leaves.
fn worst(config: &BakeConfig, judgement: &Judgement) -> Vec<u32> {
    let target = f64::from(config.target).powi(2);
    let mut cells: Vec<_> = judgement
        .cells
        .iter()
        .filter(|c| c.square_error > target)
        .collect();
    let adds = |c: &&crate::judge::CellJudgement| c.measure * c.square_error;
    cells.sort_by(|a, b| adds(b).total_cmp(&adds(a)).then(a.cell.cmp(&b.cell)));
    let room = (config.most_cells as usize).saturating_sub(judgement.cells.len());
    cells.iter().take(room).map(|c| c.cell).collect()
}

/// Splits a cell where that leaves both sides rows enough; both are fitted anew.
fn split(run: &Run, plan: &RoundPlan, next: &mut RoundPlan, cell: u32) -> Result<(), BakeError> {
    let Some(old) = plan.cells.get(cell as usize) else {
        return Ok(());
    };
    let table = read_cell(run, old)?;
    let fewest = run.config.extract.fewest_rows as usize;
    let config = &run.config.extract;
    let Some((axis, at)) = cut(&table.columns, plan.diagonal, config.weights, fewest) else {
        return Ok(());
    };
    let column = &table.columns.columns[axis];
    let left = column.iter().filter(|&&x| x < at).count() as f64 / column.len() as f64;
    let new = next.cells.len() as u32;
    let leaf = next.tree.leaves()[cell as usize];
    next.tree.split(leaf, axis, at, new);
    let [low, high] = [(cell, left), (new, 1.0 - left)].map(|(id, share)| CellPlan {
        cell: id,
        measure: old.measure * share,
        parts: taken(old, id),
        size: old.size.clone(),
        fitted: next.round,
    });
    next.cells[cell as usize] = low;
    next.cells.push(high);
    Ok(())
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
