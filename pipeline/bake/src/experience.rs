//! What remedies came to in this run: over what they were said to leave of a cell's squared error,
//! what they left.
//!
//! Scenes differ in what helps them. Under an overhead light twice the rows did as much for a cell
//! of glossy walls as a split; with lights anywhere they hardly helped (docs/accuracy.md).

use crate::error::BakeError;
use crate::judge::CellJudgement;
use crate::plan::RoundPlan;
use crate::remedy::{Action, Kind, Remedy};
use crate::run::Run;
use rrf_field::tree::Tree;
use rrf_train::cut::Cut;
use std::collections::BTreeMap;

/// Rounds that count.
const LAST: u32 = 4;
/// Mean cells that are taken to have come out as said, before any has.
const PRIOR: f64 = 3.0;

/// What came of each kind of remedy: left over said to be left.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Experience {
    /// By kind: said to be left, and left, of the whole's squared error.
    sums: BTreeMap<Kind, [f64; 2]>,
    /// What a mean cell adds to the whole's squared error.
    mean: f64,
}

impl Experience {
    /// From the files of the last rounds and the judgement of the round that has just ended.
    pub fn of(run: &Run, plan: &RoundPlan, judged: &[CellJudgement]) -> Result<Self, BakeError> {
        let shares = judged.iter().map(|c| c.measure * c.square_error.max(0.0));
        let mut all = Experience {
            mean: shares.sum::<f64>() / judged.len().max(1) as f64,
            ..Experience::default()
        };
        for round in (plan.round + 1).saturating_sub(LAST).max(1)..=plan.round {
            let Some(before) = run.read_judged(round - 1)? else {
                continue;
            };
            if round == plan.round {
                all.add(plan, &before.remedies, judged);
            } else if let (Some(plan), Some(after)) =
                (run.read_plan(round)?, run.read_judged(round)?)
            {
                all.add(&plan, &before.remedies, &after.judgement.cells);
            }
        }
        Ok(all)
    }

    /// A round: what it did, what had been said, and what came of it.
    fn add(&mut self, plan: &RoundPlan, said: &[Remedy], judged: &[CellJudgement]) {
        let mut treated: BTreeMap<u32, (Vec<u32>, f64)> = BTreeMap::new();
        for (cell, after) in plan.cells.iter().zip(judged) {
            let from = cell.earlier.as_ref().filter(|_| cell.fitted == plan.round);
            if let Some(from) = from {
                let (cells, left) = treated.entry(from.cell).or_default();
                cells.push(cell.cell);
                *left += after.measure * after.square_error;
            }
        }
        for (cell, (cells, left)) in treated {
            let size = plan.cells.get(cells[0] as usize).map(|c| &c.size);
            let done = |action: &Action| match action {
                Action::Split { cut, .. } => cells.len() == 2 && was_cut(&plan.tree, cells[0], cut),
                Action::Grow(larger) => Some(larger) == size,
                Action::More => cells.len() == 1,
            };
            let of_cell = said.iter().filter(|r| r.cell == cell && done(&r.action));
            let mut done: Vec<&Remedy> = of_cell.collect();
            // a larger net also is one cell; a cut that two rules meant counts for both
            if done.iter().any(|r| matches!(r.action, Action::Grow(_))) {
                done.retain(|r| r.action != Action::More);
            }
            for remedy in done {
                let sums = self.sums.entry(remedy.action.kind()).or_default();
                *sums = [sums[0] + remedy.left, sums[1] + left];
            }
        }
    }

    /// What should be left of a cell's share after a remedy. Estimates of what was left may come out
    /// below zero; what is left cannot.
    pub fn left(&self, remedy: &Remedy) -> f64 {
        let [said, left] = self
            .sums
            .get(&remedy.action.kind())
            .copied()
            .unwrap_or_default();
        let prior = (PRIOR * self.mean).max(f64::MIN_POSITIVE);
        remedy.left * (prior + left).max(0.0) / (prior + said)
    }
}

/// Whether a cell is one side of this cut.
fn was_cut(tree: &Tree, cell: u32, cut: &Cut) -> bool {
    let leaf = tree.leaves().get(cell as usize).copied();
    let above = leaf.and_then(|leaf| tree.parent(leaf));
    above.is_some_and(|above| {
        let axis = usize::try_from(tree.axis[above]);
        axis == Ok(cut.axis) && tree.threshold[above] == cut.threshold
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{Earlier, one_cell};
    use rrf_train::Size;
    use rrf_train::cut::Rule;

    fn remedy(cell: u32, action: Action, left: f64) -> Remedy {
        Remedy {
            cell,
            action,
            share: 1.0,
            left,
            seconds: 1.0,
            rows: 1,
            paths: 64,
        }
    }

    fn judged(cell: u32, square_error: f64) -> CellJudgement {
        CellJudgement {
            cell,
            measure: 0.25,
            square_error,
            square_error_se: 0.0,
            train_square_error: 0.0,
            noise: 0.0,
            train_rows: 100,
            effective_parameters: 1.0,
            rows: 100,
            weights: 1,
        }
    }

    /// Cell 0 became 0 and 3, cell 1 got more rows, cell 2 a larger net: each is held against what
    /// was said of it, and of nothing else; cells that were left alone do not count.
    #[test]
    fn holds_what_was_left_against_what_was_said() {
        let mut plan = one_cell(64);
        plan.round = 1;
        let cell = |id: u32, from: u32, size: &[usize]| crate::plan::CellPlan {
            cell: id,
            fitted: 1,
            size: Size::Hidden(size.to_vec()),
            earlier: Some(Earlier {
                round: 0,
                cell: from,
                task: String::new(),
            }),
            ..one_cell(64).cells[0].clone()
        };
        let small: &[usize] = &[20, 10];
        plan.cells = vec![
            cell(0, 0, small),
            cell(1, 1, small),
            cell(2, 2, &[32, 16]),
            cell(3, 0, small),
            crate::plan::CellPlan {
                fitted: 0,
                ..cell(4, 4, small)
            },
        ];
        for (from, axis, new) in [(0, 0, 1), (1, 0, 2), (0, 1, 3), (2, 0, 4)] {
            let leaf = plan.tree.leaves()[from];
            plan.tree.split(leaf, axis, 0.25, new);
        }
        let split = |rule| Action::Split {
            rule,
            cut: Cut {
                axis: if rule == Rule::Logarithm { 1 } else { 5 },
                threshold: 0.25,
                before: 1.0,
                after: 0.5,
            },
            left: 0.5,
        };
        let grow = || Action::Grow(Size::Hidden(vec![32, 16]));
        let said: Vec<Remedy> = (0..5)
            .flat_map(|c| {
                let splits = [Rule::Logarithm, Rule::Relative].map(|rule| (split(rule), 0.7));
                let each = [(Action::More, 0.6), (grow(), 0.9)];
                let each = [splits, each].concat();
                each.into_iter()
                    .map(move |(action, left)| remedy(c, action, left))
            })
            .collect();
        let after = [0.8, 2.0, 4.0, 1.2, 9.0];
        let after: Vec<CellJudgement> = (0..).zip(after).map(|(c, e)| judged(c, e)).collect();
        let mut all = Experience::default();
        all.add(&plan, &said, &after);
        let of_rule = |rule| all.sums.get(&Kind::Split(rule));
        assert_eq!(
            of_rule(Rule::Logarithm),
            Some(&[0.7, 0.25 * 0.8 + 0.25 * 1.2])
        );
        assert_eq!(of_rule(Rule::Relative), None, "another cut than was made");
        assert_eq!(all.sums[&Kind::More], [0.6, 0.5]);
        assert_eq!(all.sums[&Kind::Grow], [0.9, 1.0]);
        let left = all.left(&remedy(9, Action::More, 0.3));
        assert!((left - 0.3 * 0.5 / 0.6).abs() < 1e-12, "{left}");
        // before anything is known, as said
        assert_eq!(Experience::default().left(&said[0]), 0.7);
        all.mean = 1e6;
        assert!((all.left(&said[0]) - 0.7).abs() < 1e-5);
    }
}
