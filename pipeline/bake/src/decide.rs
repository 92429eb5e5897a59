//! After a round: stop, or what the next one does.
//!
//! Every cell that misses the target has a remedy ([`crate::remedy`]): a split, more rows, or a
//! larger net, whichever promises most error removed a second. The next round takes the best of
//! them until the whole should meet the target or they make up most of what could be gained;
//! the other cells are left alone.

use crate::config::BakeConfig;
use crate::error::BakeError;
use crate::job::{Boxes, Shared};
use crate::judge::{CellJudgement, Judgement};
use crate::plan::{CellPlan, Earlier, PartPlan, RoundPlan, draw_parts};
use crate::remedy::{Action, Remedy, best_remedy};
use crate::run::Run;
use crate::task::cell_hashes;
use rayon::prelude::*;
use rrf_train::quadratic::Cut;
use serde::{Deserialize, Serialize};

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
    /// The error cannot be told from zero by the rows held out.
    Noise,
    /// The time limit.
    Time,
}

impl Stop {
    /// In words.
    pub fn text(self) -> &'static str {
        match self {
            Stop::Target => "the target is reached",
            Stop::Rounds => "all rounds of the preset are done",
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
const SHARE: f64 = 0.75;
/// Or until the whole should come to this share of the target: predictions are rough.
const AIM: f64 = 0.95;
/// Standard errors within which an error counts as zero.
const HIDDEN: f64 = 2.0;

/// Decides from the round's plan, samples and judgement alone, so that a resumed run decides
/// the same.
pub fn decide(run: &Run, plan: &RoundPlan, judgement: &Judgement) -> Result<Next, BakeError> {
    if let Some(stop) = stop(&run.config, plan, judgement) {
        return Ok(Next::Stop(stop));
    }
    let remedies = chosen(run, judgement, remedies(run, plan, judgement)?);
    if remedies.is_empty() {
        return Ok(Next::Stop(Stop::NothingToSplit));
    }
    let mut next = RoundPlan {
        round: plan.round + 1,
        ..plan.clone()
    };
    let (boxes, shared) = (Boxes::new(&plan.tree), Shared::of(plan));
    for remedy in &remedies {
        if let Some(cell) = plan.cells.get(remedy.cell as usize) {
            let (_, fit) = cell_hashes(run, &shared, &boxes.of_cell(plan, cell)?)?;
            apply(&mut next, remedy, fit);
        }
    }
    Ok(Next::Round(Box::new(next)))
}

fn stop(config: &BakeConfig, plan: &RoundPlan, judgement: &Judgement) -> Option<Stop> {
    let (error, se) = (judgement.relative_error, judgement.relative_error_se);
    if error + se <= f64::from(config.target) {
        Some(Stop::Target)
    } else if error <= HIDDEN * se {
        Some(Stop::Noise)
    } else if plan.round + 1 >= config.rounds {
        Some(Stop::Rounds)
    } else {
        None
    }
}

/// The best remedy of every cell that misses the target.
fn remedies(run: &Run, plan: &RoundPlan, judgement: &Judgement) -> Result<Vec<Remedy>, BakeError> {
    let target = f64::from(run.config.target).powi(2);
    let may_split = plan.cells.len() < run.config.most_cells as usize;
    let misses: Vec<&CellJudgement> = judgement
        .cells
        .iter()
        .filter(|c| c.square_error > target)
        .collect();
    let found = misses
        .into_par_iter()
        .map(|judged| match plan.cells.get(judged.cell as usize) {
            Some(cell) => best_remedy(run, plan, cell, judged, may_split),
            None => Ok(None),
        })
        .collect::<Result<Vec<Option<Remedy>>, BakeError>>()?;
    Ok(found.into_iter().flatten().collect())
}

/// Those that the round takes, by cell.
fn chosen(run: &Run, judgement: &Judgement, mut remedies: Vec<Remedy>) -> Vec<Remedy> {
    let rate = |r: &Remedy| r.gain / r.seconds.max(f64::MIN_POSITIVE);
    remedies.sort_by(|a, b| rate(b).total_cmp(&rate(a)).then(a.cell.cmp(&b.cell)));
    let possible: f64 = remedies.iter().map(|r| r.gain).sum();
    let sought = AIM * f64::from(run.config.target).min(judgement.relative_error);
    let wanted = (SHARE * possible).min(judgement.relative_error.powi(2) - sought.powi(2));
    let mut room = (run.config.most_cells as usize).saturating_sub(judgement.cells.len());
    let mut gained = 0.0;
    let mut taken = Vec::new();
    for remedy in remedies {
        if gained >= wanted {
            break;
        }
        if matches!(remedy.action, Action::Split { .. }) {
            if room == 0 {
                continue;
            }
            room -= 1;
        }
        gained += remedy.gain;
        taken.push(remedy);
    }
    taken.sort_by_key(|r| r.cell);
    taken
}

/// Writes a remedy into the next round's plan; `fit` is the hash of the cell's fit so far.
fn apply(next: &mut RoundPlan, remedy: &Remedy, fit: String) {
    let Some(old) = next.cells.get(remedy.cell as usize).cloned() else {
        return;
    };
    match &remedy.action {
        Action::Split { cut, left } => split(next, &old, remedy, cut, *left, fit),
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
fn earlier(cell: &CellPlan, task: String) -> Earlier {
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
        let drawn = draw_parts(&mut next.draws, leaf as u32, rows, paths, first);
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
mod tests {
    use super::*;
    use crate::plan::one_cell;
    use crate::task::expected_rows;
    use rrf_field::columns;
    use rrf_train::Size;

    /// Each reason to stop at its border, and none beside it.
    #[test]
    fn stops_where_it_should() {
        let light_box = rrf_extract::LightBox {
            minimum: [0.0; 3],
            maximum: [1.0; 3],
        };
        let config = BakeConfig {
            target: 0.05,
            rounds: 3,
            ..BakeConfig::preset(crate::Preset::Standard, light_box, 1)
        };
        let after = |round: u32, relative_error: f64, relative_error_se: f64| {
            let plan = RoundPlan {
                round,
                ..one_cell(256)
            };
            let judgement = Judgement {
                relative_error,
                relative_error_se,
                cells: Vec::new(),
            };
            stop(&config, &plan, &judgement)
        };
        assert_eq!(after(0, 0.048, 0.001), Some(Stop::Target));
        assert_eq!(after(0, 0.048, 0.003), None);
        assert_eq!(after(0, 0.060, 0.031), Some(Stop::Noise));
        assert_eq!(after(0, 0.060, 0.029), None);
        assert_eq!(after(1, 0.060, 0.001), None);
        assert_eq!(after(2, 0.060, 0.001), Some(Stop::Rounds));
    }

    fn remedy(action: Action, rows: u32) -> Remedy {
        Remedy {
            cell: 0,
            action,
            gain: 1.0,
            seconds: 1.0,
            rows,
            paths: 128,
        }
    }

    fn cut() -> Cut {
        Cut {
            axis: columns::L,
            threshold: 0.5,
            before: 1.0,
            after: 0.5,
        }
    }

    /// Children take their parent's rows and are filled up to as many each; a second split does
    /// the same to a child, and the plan stays sound.
    #[test]
    fn children_keep_rows_and_get_the_rest() {
        let mut plan = one_cell(256);
        plan.round = 1;
        apply(
            &mut plan,
            &remedy(
                Action::Split {
                    cut: cut(),
                    left: 0.3,
                },
                6000,
            ),
            "first".into(),
        );
        plan.check().unwrap();
        assert_eq!(expected_rows(&plan), [6000, 6000]);
        let measures: Vec<f64> = plan.cells.iter().map(|c| c.measure).collect();
        assert_eq!(measures, [0.3, 0.7]);
        assert_eq!(plan.cells[1].parts[0].from, Some([0, 0]));
        let from = |cell: usize| plan.cells[cell].earlier.clone().unwrap();
        assert_eq!(from(0), from(1));
        assert_eq!((from(0).round, from(0).task.as_str()), (0, "first"));
        plan.round = 2;
        apply(&mut plan, &remedy(Action::More, 6000), "second".into());
        plan.check().unwrap();
        assert_eq!(expected_rows(&plan), [12_000, 6000]);
        assert_eq!((plan.cells[0].fitted, plan.cells[1].fitted), (2, 1));
        let from = plan.cells[0].earlier.clone().unwrap();
        assert_eq!(
            (from.round, from.cell, from.task.as_str()),
            (1, 0, "second")
        );
        let parts: Vec<u32> = plan.cells[0].parts.iter().map(|p| p.part).collect();
        assert_eq!(parts, [1, 2, 3], "numbers of parts are never used twice");
    }

    #[test]
    fn a_larger_net_draws_nothing() {
        let mut plan = one_cell(256);
        plan.round = 1;
        let size = Size::Hidden(vec![32, 16]);
        apply(
            &mut plan,
            &remedy(Action::Grow(size.clone()), 0),
            "first".into(),
        );
        plan.check().unwrap();
        assert_eq!((plan.draws.len(), &plan.cells[0].size), (1, &size));
        assert_eq!(plan.cells[0].fitted, 1);
    }
}
