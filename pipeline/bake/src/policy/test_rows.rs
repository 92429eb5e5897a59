//! Test rows, in `test/`: no fit sees them, and no choice about a cell depends on them.
//!
//! Held-out rows choose weights, the cells that are left alone and what is compressed. With hundreds
//! of cells that makes the error on them too small. Test rows decide when a bake ends. They are drawn
//! over the whole domain, as samples are, and belong to no cell.

use crate::plan::evaluation::{Evaluation, TestError};
use crate::plan::round::{DrawPlan, RoundPlan, draw_parts};
use crate::settings::BakeConfig;
use rrf_field::{Field, FieldError};
use rrf_metrics::estimate::{ErrorEstimate, by_halves};
use rrf_metrics::relative::{channel_mean, inverse_level};
use rrf_store::samples::SampleTable;

/// Paths of a test row relative to a first sample, and the minimum: less noise by more rows costs more
/// than by more paths.
const PATHS: u32 = 4;
const MIN_PATHS: u32 = 512;
/// Share of all paths that go to test rows as a run proceeds, and the maximum where its end depends
/// on them.
const SHARE: f64 = 1.0 / 16.0;
const MAX_SHARE: f64 = 0.25;
/// Minimum of rows: fewer have no meaningful standard error.
const MIN_ROWS: u32 = 64;
/// Maximum rows of a draw, so that all threads have some.
const DRAW: u32 = 2048;
/// New rows get a file of their own from this share of the existing ones on.
const WORTH: f64 = 0.25;
/// A standard error below this share of the target is small enough.
const PRECISE: f64 = 0.02;

/// Paths of a test row.
fn paths_of(paths: u32) -> u32 {
    (PATHS * paths).max(MIN_PATHS)
}

/// Adds test rows to the plan of a round in proportion to its samples, unless the existing ones are
/// precise enough.
pub(crate) fn keep_up(
    next: &mut RoundPlan,
    paths: u32,
    target: f64,
    evaluation: Option<&Evaluation>,
) {
    let test = evaluation.and_then(|e| e.test);
    if !test.is_some_and(|t| precise(&t, target)) {
        draw(next, paths_of(paths), SHARE);
    }
}

/// A round that only doubles the test rows, where these cannot tell whether the target is met. It does
/// not take the place of the last round that could refine a cell.
pub(crate) fn more(
    config: &BakeConfig,
    plan: &RoundPlan,
    evaluation: &Evaluation,
) -> Option<RoundPlan> {
    let (target, paths) = (f64::from(config.target), config.extract.paths);
    let test = evaluation.test?;
    let (error, se) = (test.relative_error, test.relative_error_se);
    let undecided = (error - target).abs() < se && !precise(&test, target);
    if !undecided || plan.round + 2 >= config.rounds {
        return None;
    }
    let [samples, tests] = paths_drawn(plan);
    let share = (2.0 * tests / samples).min(MAX_SHARE);
    let mut next = plan.next();
    draw(&mut next, paths_of(paths), share).then_some(next)
}

fn precise(test: &TestError, target: f64) -> bool {
    test.relative_error_se <= PRECISE * target
}

/// Paths of all samples, and of all test rows.
fn paths_drawn(plan: &RoundPlan) -> [f64; 2] {
    let paths = |draw: &DrawPlan| f64::from(draw.rows) * f64::from(draw.paths);
    let all: f64 = plan.draws.iter().map(paths).sum();
    let tests = plan.tests.iter();
    let tests = tests.filter_map(|part| plan.draws.get(part.draw as usize));
    let tests: f64 = tests.map(paths).sum();
    [all - tests, tests]
}

/// Adds test rows of `paths` paths each until they have `share` of the paths of all samples. Returns
/// whether there are new ones.
fn draw(next: &mut RoundPlan, paths: u32, share: f64) -> bool {
    let [samples, tests] = paths_drawn(next).map(|drawn| drawn / f64::from(paths));
    let new = share * samples - tests;
    let rows = match next.tests.is_empty() {
        true => (new as u32).max(MIN_ROWS),
        false if new >= WORTH * tests => new as u32,
        false => return false,
    };
    let first = next.tests.len() as u32;
    let parts = draw_parts(&mut next.draws, 0, rows, paths, first, DRAW);
    next.tests.extend(parts);
    true
}

/// The error of a field on the test rows; none where they are too few.
pub(crate) fn evaluate(rows: &[TestRow], floor: f64) -> Option<TestError> {
    if rows.len() < MIN_ROWS as usize / 2 {
        return None;
    }
    let error = error(rows, floor);
    Some(TestError {
        rows: rows.len() as u64,
        relative_error: error.relative(),
        relative_error_se: error.relative_se(),
    })
}

/// The prediction of a model at a point and the two half estimates there.
#[derive(Clone, Copy)]
pub(crate) struct TestRow {
    p: [f64; 3],
    halves: [[f32; 3]; 2],
}

impl TestRow {
    /// Mean of the halves.
    fn y(&self) -> [f64; 3] {
        let [a, b] = self.halves.map(|half| half.map(f64::from));
        [0, 1, 2].map(|c| 0.5 * (a[c] + b[c]))
    }

    /// Squared noise of the mean for one channel.
    fn noise(&self) -> f64 {
        let [a, b] = self.halves.map(|half| half.map(f64::from));
        (0..3).map(|c| (0.5 * (a[c] - b[c])).powi(2)).sum::<f64>() / 3.0
    }
}

/// The rows of a part with the predictions of a field, without those that are not finite.
///
/// # Errors
/// [`FieldError`].
pub(crate) fn predicted(field: &Field, table: &SampleTable) -> Result<Vec<TestRow>, FieldError> {
    let mut rgb = [const { Vec::new() }; 3];
    field.evaluate(&table.columns, &mut rgb, &mut Vec::new())?;
    let [first, second] = &table.halves;
    let rows = first.iter().zip(second).enumerate();
    let rows = rows.map(|(i, (&first, &second))| TestRow {
        p: [0, 1, 2].map(|c| f64::from(rgb[c][i])),
        halves: [first, second],
    });
    let finite = |row: &TestRow| row.p.iter().chain(&row.y()).all(|x| x.is_finite());
    Ok(rows.filter(finite).collect())
}

/// Divides errors by a mixture of target and prediction, each weighted by the other's error, as fits do.
/// The iteration starts from the prediction alone: noisy targets in the divisor add an error of 6σ⁴,
/// which would give them too much weight for good.
fn error(rows: &[TestRow], floor: f64) -> ErrorEstimate {
    let by = |share: f64| -> (ErrorEstimate, f64) {
        let divisor = |row: &TestRow| {
            let mixed = share * channel_mean(row.y()) + (1.0 - share) * channel_mean(row.p);
            inverse_level(mixed, floor)
        };
        let value = |row: &TestRow| by_halves(row.p, row.halves[0], row.halves[1], divisor(row));
        let values: Vec<f64> = rows.iter().map(value).collect();
        let noise = |row: &TestRow| row.noise() * divisor(row).powi(2);
        let noise = rows.iter().map(noise).sum::<f64>() / rows.len() as f64;
        (ErrorEstimate::of(&values), noise)
    };
    let mut found = by(0.0);
    for _ in 0..RENEWALS {
        let square = found.0.square.max(LEAST * LEAST);
        found = by(square / (square + found.1));
    }
    found.0
}

/// Smallest error that a model is weighted with.
const LEAST: f64 = 1e-3;
/// Number of updates of the mixture from the errors that it gives; the third changes nothing any more.
const RENEWALS: usize = 3;

#[cfg(test)]
mod tests;
