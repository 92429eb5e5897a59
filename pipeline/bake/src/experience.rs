//! What remedies came to in this run: over what they were said to leave of a cell's squared error,
//! what they left.
//!
//! Scenes differ in what helps them. Under an overhead light twice the rows did as much for a cell
//! of glossy walls as a split; with lights anywhere they hardly helped (docs/accuracy.md).

use crate::error::BakeError;
use crate::judge::CellJudgement;
use crate::plan::{CellPlan, RoundPlan};
use crate::remedy::{Action, Kind, Remedy};
use crate::run::Run;
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
        let cuts = plan.tree.last_cuts();
        let mut said_of: BTreeMap<u32, Vec<&Remedy>> = BTreeMap::new();
        for remedy in said {
            said_of.entry(remedy.cell).or_default().push(remedy);
        }
        // by the cell that was treated: what it became, and what is left of its error
        let mut treated: BTreeMap<u32, (Vec<&CellPlan>, f64)> = BTreeMap::new();
        for after in judged {
            let cell = plan.cells.get(after.cell as usize);
            let now = cell.filter(|cell| cell.fitted == plan.round);
            if let Some((cell, from)) = now.and_then(|c| Some((c, c.earlier.as_ref()?))) {
                let (cells, left) = treated.entry(from.cell).or_default();
                cells.push(cell);
                *left += after.measure * after.square_error;
            }
        }
        for (cell, (cells, left)) in treated {
            let done_so = |action: &Action| match (action, cells.as_slice()) {
                (Action::Split { cut, .. }, [one, _]) => {
                    cuts.get(one.cell as usize) == Some(&Some((cut.axis, cut.threshold)))
                }
                (Action::Grow(larger), [one]) => one.size == *larger,
                (Action::More, [_]) => true,
                _ => false,
            };
            let mut done: Vec<&Remedy> = said_of.remove(&cell).unwrap_or_default();
            done.retain(|r| done_so(&r.action));
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{Earlier, one_cell};
    use rrf_train::Size;
    use rrf_train::cut::{Cut, Rule};

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
        let cell = |id: u32, from: u32, size: &[usize]| CellPlan {
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
            CellPlan {
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
        // in any order: a cell without rows to judge it by is not among them
        let after = [(4, 9.0), (2, 4.0), (0, 0.8), (1, 2.0), (3, 1.2)];
        let after = after.map(|(c, e)| judged(c, e));
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
