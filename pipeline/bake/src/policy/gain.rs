//! Calibration of predicted gains: the ratio of the measured to the predicted remaining error of
//! each kind of action, over the last rounds of this run.
//!
//! Scenes differ in what helps them. Under an overhead light twice the rows did as much for a cell
//! of glossy walls as a split; with lights anywhere they hardly helped (docs/science/report.md).

use crate::plan::evaluation::CellEvaluation;
use crate::plan::refinement::{Action, Refinement, RefinementKind};
use crate::plan::round::{CellPlan, RoundPlan};
use std::collections::BTreeMap;
use std::ops::RangeInclusive;

/// Number of rounds that count.
const LAST: u32 = 4;
/// Weight of the predictions themselves, in mean cells that came out as predicted.
const PRIOR: f64 = 3.0;

/// The rounds up to `last` whose actions calibrate those of the next.
pub(crate) fn rounds(last: u32) -> RangeInclusive<u32> {
    (last + 1).saturating_sub(LAST).max(1)..=last
}

/// Predicted and measured remaining error, summed by kind of action.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct GainCalibration {
    /// Predicted and measured, as contributions to the squared error of the whole.
    sums: BTreeMap<RefinementKind, [f64; 2]>,
    /// Mean contribution of a cell to the squared error of the whole.
    mean: f64,
}

impl GainCalibration {
    /// Starts from the predictions alone; `cells` are those of the latest evaluation.
    pub fn new(cells: &[CellEvaluation]) -> GainCalibration {
        let shares = cells.iter().map(|c| c.measure * c.square_error.max(0.0));
        GainCalibration {
            mean: shares.sum::<f64>() / cells.len().max(1) as f64,
            sums: BTreeMap::new(),
        }
    }

    /// Adds a round: its plan, what had been predicted before it, and its evaluation.
    pub fn add(&mut self, plan: &RoundPlan, predicted: &[Refinement], cells: &[CellEvaluation]) {
        let cuts = plan.tree.last_cuts();
        let mut predicted_of: BTreeMap<u32, Vec<&Refinement>> = BTreeMap::new();
        for refinement in predicted {
            let of_cell = predicted_of.entry(refinement.cell).or_default();
            of_cell.push(refinement);
        }
        // by the cell that was refined: its successors, and their remaining error
        let mut refined: BTreeMap<u32, (Vec<&CellPlan>, f64)> = BTreeMap::new();
        for after in cells {
            let cell = plan.cells.get(after.cell as usize);
            let now = cell.filter(|cell| cell.fitted == plan.round);
            if let Some((cell, from)) = now.and_then(|c| Some((c, c.earlier.as_ref()?))) {
                let (cells, left) = refined.entry(from.cell).or_default();
                cells.push(cell);
                *left += after.measure * after.square_error;
            }
        }
        for (cell, (cells, left)) in refined {
            let was_done = |action: &Action| match (action, cells.as_slice()) {
                (Action::Split { cut, .. }, [one, _]) => {
                    cuts.get(one.cell as usize) == Some(&Some((cut.axis, cut.threshold)))
                }
                (Action::LargerNet(larger), [one]) => one.size == *larger,
                (Action::MoreRows, [_]) => true,
                _ => false,
            };
            let mut done: Vec<&Refinement> = predicted_of.remove(&cell).unwrap_or_default();
            done.retain(|r| was_done(&r.action));
            // a larger net also leaves one cell; a cut that two rules chose counts for both
            if done
                .iter()
                .any(|r| matches!(r.action, Action::LargerNet(_)))
            {
                done.retain(|r| r.action != Action::MoreRows);
            }
            for refinement in done {
                let sums = self.sums.entry(refinement.action.kind()).or_default();
                *sums = [sums[0] + refinement.left, sums[1] + left];
            }
        }
    }

    /// Calibrated remaining contribution of a cell after an action. Estimates of a remaining error can
    /// be negative; the result cannot.
    pub fn left(&self, refinement: &Refinement) -> f64 {
        let kind = refinement.action.kind();
        let [predicted, measured] = self.sums.get(&kind).copied().unwrap_or_default();
        let prior = (PRIOR * self.mean).max(f64::MIN_POSITIVE);
        refinement.left * (prior + measured).max(0.0) / (prior + predicted)
    }
}

#[cfg(test)]
mod tests;
