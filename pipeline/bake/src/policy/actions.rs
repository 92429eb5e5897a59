//! Possible refinements of a cell, with their predicted gain and cost.
//!
//! The squared error of a cell is split into two parts: the *fit*, which is the error on the training
//! rows, and the *gap* between that and the error on held-out rows. The factors by which an action
//! changes either were measured (docs/science/report.md). [`best_cut`] finds the place of a split.

use crate::plan::evaluation::CellEvaluation;
use crate::plan::refinement::{Action, Refinement};
use crate::plan::round::{CellPlan, PartPlan, RoundPlan};
use crate::policy::cost;
use crate::policy::tasks::fit_config;
use crate::settings::BakeConfig;
use rrf_metrics::relative::epsilon;
use rrf_store::samples::SampleTable;
use rrf_train::cut::{Cut, Rule, best_cut};
use rrf_train::{ARCHITECTURES, Size};

/// Factors of fit and gap when two cells with as many rows each replace one.
const SPLIT: [f64; 2] = [0.6, 0.85];
/// Factors with twice the rows.
const MORE_ROWS: [f64; 2] = [1.0, 0.7];
/// Factors with a larger net.
const LARGER_NET: [f64; 2] = [0.95, 1.1];

/// All possible refinements of a cell that has `rows` rows, `table` among them.
pub(crate) fn refinements_of(
    config: &BakeConfig,
    plan: &RoundPlan,
    cell: &CellPlan,
    evaluated: &CellEvaluation,
    table: &SampleTable,
    rows: u32,
) -> Vec<Refinement> {
    let fit = evaluated
        .train_square_error
        .clamp(0.0, evaluated.square_error.max(0.0));
    let gap = evaluated.square_error - fit;
    let paths = paths(config, plan, cell, evaluated);
    let train = fit_config(config, plan.mean_radiance, cell);
    let fit_seconds = |size: &Size, rows| cost::train_seconds(rows, size, &train, true);
    let draw_seconds = cost::draw_seconds(rows, paths, plan.path_seconds);
    let more_seconds = draw_seconds + fit_seconds(&cell.size, 2 * u64::from(rows));
    let mut found: Vec<Refinement> = Vec::new();
    let mut consider = |action, [of_fit, of_gap]: [f64; 2], seconds, rows| {
        found.push(Refinement {
            cell: cell.cell,
            action,
            share: evaluated.measure * evaluated.square_error,
            left: evaluated.measure * (of_fit * fit + of_gap * gap),
            seconds,
            rows,
            paths,
        });
    };
    // the rules take turns until one has done better
    let turns = match (plan.round + cell.cell) % 2 {
        0 => [Rule::Logarithm, Rule::Relative],
        _ => [Rule::Relative, Rule::Logarithm],
    };
    for rule in turns {
        if let Some((cut, left)) = cut(rule, config, plan, table) {
            let action = Action::Split { rule, cut, left };
            consider(action, SPLIT, more_seconds, rows);
        }
    }
    consider(Action::MoreRows, MORE_ROWS, more_seconds, rows);
    if let Some(size) = larger(&cell.size) {
        let seconds = fit_seconds(&size, u64::from(rows));
        consider(Action::LargerNet(size), LARGER_NET, seconds, 0);
    }
    found
}

/// The best cut and the share of rows on its left.
fn cut(
    rule: Rule,
    config: &BakeConfig,
    plan: &RoundPlan,
    table: &SampleTable,
) -> Option<(Cut, f64)> {
    let halves = [table.halves[0].as_slice(), table.halves[1].as_slice()];
    let floor = epsilon(config.train.epsilon, f64::from(plan.mean_radiance));
    let lambert = |&m: &u32| plan.lambert.get(m as usize).copied().unwrap_or(false);
    let glossy = !table.material.iter().all(lambert);
    let fewest = config.extract.fewest_rows as usize;
    let cut = best_cut(rule, &table.columns, halves, floor, fewest, glossy)?;
    let column = &table.columns.columns[cut.axis];
    let left = column.iter().filter(|&&x| x < cut.threshold).count();
    Some((cut, left as f64 / column.len().max(1) as f64))
}

/// The next larger net in the list of architectures.
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
/// error and take as much from the error on the training rows, so that the gap is twice this. Here
/// v is the unexplained variance of a noise-free row and σ² the squared noise of one path. A row costs
/// t + c P seconds (candidates and fit; paths). For a given time the gap is smallest at P² = σ² t / (v c).
fn paths(
    config: &BakeConfig,
    plan: &RoundPlan,
    cell: &CellPlan,
    evaluated: &CellEvaluation,
) -> u32 {
    let draw = |p: &PartPlan| plan.draws.get(p.draw as usize);
    let used = cell.parts.iter().filter_map(draw);
    let (sum, count) = used.fold((0.0, 0.0), |(s, n), d| (s + f64::from(d.paths), n + 1.0));
    let now = match count > 0.0 {
        true => sum / count,
        false => f64::from(config.extract.paths),
    };
    let one_path = evaluated.noise.powi(2) * now;
    let gap = evaluated.square_error - evaluated.train_square_error.max(0.0);
    let parameters = evaluated.effective_parameters.max(1.0);
    let unexplained = 0.5 * gap * evaluated.train_rows as f64 / parameters - one_path / now;
    let path = plan.path_seconds;
    let row = cost::train_seconds(1, &cell.size, &config.train, true);
    let ratio = (row + cost::draw_seconds(1, 0, path)) / path;
    let best = (one_path * ratio / unexplained.max(f64::MIN_POSITIVE)).sqrt();
    // a power of two: even, and the strata of the paths' Sobol points stay whole
    2f64.powf(best.clamp(MIN_PATHS, MAX_PATHS).log2().round()) as u32
}

const MIN_PATHS: f64 = 64.0;
const MAX_PATHS: f64 = 512.0;

#[cfg(test)]
mod tests;
