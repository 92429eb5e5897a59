//! What could be done about a cell, what it should remove and what it should cost.
//!
//! The squared error of a cell is taken for the sum of two: what its net cannot follow even on
//! the rows it learned from (*fit*, the error on the training rows) and what the rows did not
//! tell it (*gap*, the rest). What a remedy leaves of either was measured (docs/accuracy.md); where
//! to cut a cell, regression says ([`best_cut`]).

use crate::config::BakeConfig;
use crate::cost;
use crate::judge::CellJudgement;
use crate::plan::{CellPlan, RoundPlan};
use crate::run::Run;
use crate::seams::epsilon;
use crate::work::read_some;
use crate::{error::BakeError, task::fit_config};
use rrf_store::samples::SampleTable;
use rrf_train::cut::{Cut, Rule, best_cut};
use rrf_train::{ARCHITECTURES, Size};
use serde::{Deserialize, Serialize};

/// What may be done about a cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Action {
    /// Two cells in its place, each with as many rows as it has now.
    Split {
        /// By which rule.
        rule: Rule,
        /// Where.
        cut: Cut,
        /// Share of its rows on the left.
        left: f64,
    },
    /// As many rows again.
    More,
    /// A larger net on the same rows.
    Grow(Size),
}

/// What sort of action.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// [`Action::Split`].
    Split(Rule),
    /// [`Action::More`].
    More,
    /// [`Action::Grow`].
    Grow,
}

impl Action {
    /// Its sort.
    pub fn kind(&self) -> Kind {
        match self {
            Action::Split { rule, .. } => Kind::Split(*rule),
            Action::More => Kind::More,
            Action::Grow(_) => Kind::Grow,
        }
    }
}

/// One of these for one cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Remedy {
    /// The cell.
    pub cell: u32,
    /// What is done.
    pub action: Action,
    /// What the cell adds to the squared error of the whole.
    pub share: f64,
    /// What should be left of that, by the constants here ([`crate::experience`] corrects them).
    pub left: f64,
    /// Seconds of one core that it should take.
    pub seconds: f64,
    /// Rows to draw for it.
    pub rows: u32,
    /// Paths for each of them.
    pub paths: u32,
}

/// What two cells in place of one, with as many rows each, leave of fit and gap.
const SPLIT: [f64; 2] = [0.6, 0.85];
/// What twice the rows leave of them.
const MORE: [f64; 2] = [1.0, 0.7];
/// What a larger net makes of them.
const GROWN: [f64; 2] = [0.95, 1.1];

/// All that could be done about a cell.
pub(crate) fn remedies_of(
    run: &Run,
    plan: &RoundPlan,
    cell: &CellPlan,
    judged: &CellJudgement,
) -> Result<Vec<Remedy>, BakeError> {
    let config = &run.config;
    let (table, rows) = read_some(run, cell)?;
    let fit = judged
        .train_square_error
        .clamp(0.0, judged.square_error.max(0.0));
    let gap = judged.square_error - fit;
    let paths = paths(config, plan, cell, judged);
    let train = fit_config(run, plan.mean_luminance, cell);
    let fit_seconds = |size: &Size, rows| cost::train_seconds(rows, size, &train, true);
    let drawn_seconds = cost::draw_seconds(rows, paths, plan.path_seconds);
    let twice = fit_seconds(&cell.size, 2 * u64::from(rows));
    let leaves = |[of_fit, of_gap]: [f64; 2]| of_fit * fit + of_gap * gap;
    let mut found: Vec<Remedy> = Vec::new();
    let mut consider = |action, left: f64, seconds, rows| {
        found.push(Remedy {
            cell: cell.cell,
            action,
            share: judged.measure * judged.square_error,
            left: judged.measure * left,
            seconds,
            rows,
            paths,
        });
    };
    // they take turns until one has done better
    let turns = match (plan.round + cell.cell) % 2 {
        0 => [Rule::Logarithm, Rule::Relative],
        _ => [Rule::Relative, Rule::Logarithm],
    };
    for rule in turns {
        if let Some((cut, left)) = cut(rule, config, plan, &table) {
            let action = Action::Split { rule, cut, left };
            consider(action, leaves(SPLIT), drawn_seconds + twice, rows);
        }
    }
    consider(Action::More, leaves(MORE), drawn_seconds + twice, rows);
    if let Some(size) = larger(&cell.size) {
        let seconds = fit_seconds(&size, u64::from(rows));
        consider(Action::Grow(size), leaves(GROWN), seconds, 0);
    }
    Ok(found)
}

/// The best cut and the share of rows on its left.
fn cut(
    rule: Rule,
    config: &BakeConfig,
    plan: &RoundPlan,
    table: &SampleTable,
) -> Option<(Cut, f64)> {
    let halves = [table.halves[0].as_slice(), table.halves[1].as_slice()];
    let floor = epsilon(config.train.epsilon, plan.mean_luminance);
    let lambert = |&m: &u32| plan.lambert.get(m as usize).copied().unwrap_or(false);
    let glossy = !table.material.iter().all(lambert);
    let fewest = config.extract.fewest_rows as usize;
    let cut = best_cut(rule, &table.columns, halves, floor, fewest, glossy)?;
    let column = &table.columns.columns[cut.axis];
    let left = column.iter().filter(|&&x| x < cut.threshold).count();
    Some((cut, left as f64 / column.len().max(1) as f64))
}

/// The next larger net of the ladder.
fn larger(size: &Size) -> Option<Size> {
    let Size::Hidden(hidden) = size else {
        return None;
    };
    let units: usize = hidden.iter().sum();
    let next = ARCHITECTURES
        .iter()
        .find(|n| n.iter().sum::<usize>() > units)?;
    Some(Size::Hidden(next.to_vec()))
}

/// Paths for each new row of a cell. γ parameters fitted to N rows add (v + σ² / P) γ / N to the
/// error, and take as much from that on the training rows, so that the gap is twice this: v what a
/// noise-free row would leave unsaid, σ² the squared noise of one path. A row costs t + c P seconds
/// (candidates and fit; paths). For a given time the gap is least at P² = σ² t / (v c).
fn paths(config: &BakeConfig, plan: &RoundPlan, cell: &CellPlan, judged: &CellJudgement) -> u32 {
    let used = cell
        .parts
        .iter()
        .filter_map(|p| plan.draws.get(p.draw as usize));
    let (sum, count) = used.fold((0.0, 0.0), |(s, n), d| (s + f64::from(d.paths), n + 1.0));
    let now = if count > 0.0 {
        sum / count
    } else {
        f64::from(config.extract.paths)
    };
    let one_path = judged.noise.powi(2) * now;
    let gap = judged.square_error - judged.train_square_error.max(0.0);
    let parameters = judged.effective_parameters.max(1.0);
    let unsaid = 0.5 * gap * judged.train_rows as f64 / parameters - one_path / now;
    let (most, least) = (f64::from(MOST_PATHS), f64::from(LEAST_PATHS));
    let path = plan.path_seconds;
    let row = cost::train_seconds(1, &cell.size, &config.train, true);
    let ratio = (row + cost::draw_seconds(1, 0, path)) / path;
    let best = (one_path * ratio / unsaid.max(f64::MIN_POSITIVE)).sqrt();
    // a power of two: even, and strata of the paths' Sobol points stay whole
    2f64.powf(best.clamp(least, most).log2().round()) as u32
}

const LEAST_PATHS: u32 = 64;
const MOST_PATHS: u32 = 512;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::one_cell;
    use crate::{BakeConfig, Preset};
    use rrf_extract::Region;

    fn judged(noise: f64, gap: f64) -> CellJudgement {
        CellJudgement {
            cell: 0,
            measure: 1.0,
            square_error: 0.003 + gap,
            square_error_se: 0.0,
            train_square_error: 0.003,
            noise,
            train_rows: 4200,
            effective_parameters: 300.0,
            rows: 6000,
            weights: 443,
        }
    }

    /// The number of paths is the best of all powers of two for the time it takes.
    #[test]
    fn paths_are_the_best_for_their_time() {
        let light_box = Region {
            minimum: [0.0; 3],
            maximum: [1.0; 3],
        };
        let config = BakeConfig::preset(Preset::Standard, light_box, 1);
        for (now, noise, gap) in [(256, 0.2, 0.01), (64, 0.1, 0.02), (128, 0.3, 0.012)] {
            let (plan, judged) = (one_cell(now), judged(noise, gap));
            let chosen = paths(&config, &plan, &plan.cells[0], &judged);
            let size = &plan.cells[0].size;
            let variance = noise * noise * f64::from(now);
            let unsaid = 0.5 * gap * 4200.0 / 300.0 - noise * noise;
            let cost = |paths: u32| {
                let seconds = cost::train_seconds(1_000, size, &config.train, true)
                    + cost::draw_seconds(1_000, paths, plan.path_seconds);
                (unsaid + variance / f64::from(paths)) * seconds
            };
            for other in (6..=9).map(|k| 1u32 << k) {
                assert!(cost(chosen) <= cost(other), "{chosen}, {other} is better");
            }
        }
    }

    #[test]
    fn nets_grow_along_the_ladder() {
        let grown = larger(&Size::Hidden(vec![20, 10]));
        assert_eq!(grown, Some(Size::Hidden(vec![32, 16])));
        assert_eq!(larger(&Size::Hidden(vec![32, 16])), None);
        assert_eq!(larger(&Size::Smallest { target: 0.1 }), None);
    }
}
