//! Rows that only judge, in `test/`: no fit sees them and no choice of a cell is made by them.
//!
//! Rows held out of the cells choose weights, the cells that are left alone and what is trimmed, and with
//! hundreds of cells that makes them kind to the model. When a bake ends is decided by these. They are drawn
//! over the whole domain, as samples are, and belong to no cell.

use crate::error::BakeError;
use crate::judge::Judgement;
use crate::plan::{CellPlan, PartPlan, RoundPlan, draw_parts};
use crate::run::Run;
use crate::seams::epsilon;
use rayon::prelude::*;
use rrf_field::Field;
use rrf_store::layout::TEST;
use rrf_store::parts;
use rrf_store::samples::SampleTable;
use rrf_train::channel_mean;
use rrf_train::halves::{ErrorEstimate, product};
use serde::{Deserialize, Serialize};

/// Error of the whole on the test rows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tested {
    /// Test rows.
    pub rows: u64,
    /// As [`Judgement::relative_error`].
    pub relative_error: f64,
    /// Its standard error.
    pub relative_error_se: f64,
}

/// How many times as many paths a test row has as the first samples, and how many at the least: their noise costs
/// more rows than it costs paths to be rid of it.
const PATHS: u32 = 4;
const FEWEST_PATHS: u32 = 512;
/// Share of all paths that test rows have as a run goes on, and at most where its end hangs on them.
const SHARE: f64 = 1.0 / 16.0;
const MOST: f64 = 0.25;
/// Rows at the least: fewer have no standard error worth the name.
const FEWEST: u32 = 64;
/// Rows of a draw at the most, so that all threads have some.
const DRAW: u32 = 2048;
/// New rows are worth a file of their own where they are this share of those that there are.
const WORTH: f64 = 0.25;
/// A standard error below this share of the target is small enough.
const PRECISE: f64 = 0.02;

/// Paths of a test row.
fn paths_of(paths: u32) -> u32 {
    (PATHS * paths).max(FEWEST_PATHS)
}

/// Gives the plan of a round test rows in proportion to its samples; none where those that there are
/// tell enough.
pub(crate) fn keep_up(
    next: &mut RoundPlan,
    paths: u32,
    target: f64,
    judgement: Option<&Judgement>,
) {
    let tested = judgement.and_then(|j| j.test);
    if !tested.is_some_and(|t| precise(&t, target)) {
        draw(next, paths_of(paths), SHARE);
    }
}

/// A round that does nothing but double the test rows, where these cannot tell whether the target is met.
pub(crate) fn more(
    plan: &RoundPlan,
    paths: u32,
    target: f64,
    judgement: &Judgement,
) -> Option<RoundPlan> {
    let test = judgement.test?;
    let (error, se) = (test.relative_error, test.relative_error_se);
    let undecided = (error - target).abs() < se && !precise(&test, target);
    let [samples, tests] = spent(plan);
    let share = (2.0 * tests / samples).min(MOST);
    let mut next = RoundPlan {
        round: plan.round + 1,
        ..plan.clone()
    };
    (undecided && draw(&mut next, paths_of(paths), share)).then_some(next)
}

fn precise(tested: &Tested, target: f64) -> bool {
    tested.relative_error_se <= PRECISE * target
}

/// Paths of all samples, and of all test rows.
fn spent(plan: &RoundPlan) -> [f64; 2] {
    let paths = |draw: &crate::plan::DrawPlan| f64::from(draw.rows) * f64::from(draw.paths);
    let all: f64 = plan.draws.iter().map(paths).sum();
    let tests = plan.tests.iter();
    let tests = tests.filter_map(|part| plan.draws.get(part.draw as usize));
    let tests: f64 = tests.map(paths).sum();
    [all - tests, tests]
}

/// Test rows of `paths` paths each until they have `share` of the paths of all samples; whether there are new ones.
fn draw(next: &mut RoundPlan, paths: u32, share: f64) -> bool {
    let [samples, tests] = spent(next).map(|spent| spent / f64::from(paths));
    let new = share * samples - tests;
    let rows = match next.tests.is_empty() {
        true => (new as u32).max(FEWEST),
        false if new >= WORTH * tests => new as u32,
        false => return false,
    };
    let first = next.tests.len() as u32;
    let parts = draw_parts(&mut next.draws, 0, rows, paths, first, DRAW);
    next.tests.extend(parts);
    true
}

/// The test rows as the tasks that draw them see them: a cell of the whole domain.
pub(crate) fn as_cell(parts: &[PartPlan]) -> CellPlan {
    CellPlan {
        cell: TEST,
        measure: 1.0,
        parts: parts.to_vec(),
        size: rrf_train::Size::Hidden(Vec::new()),
        fitted: 0,
        earlier: None,
        prune: None,
    }
}

/// The error of a field on the test rows; none where they are too few.
pub(crate) fn judge(
    run: &Run,
    plan: &RoundPlan,
    field: &Field,
) -> Result<Option<Tested>, BakeError> {
    let of_part = |part: &PartPlan| -> Result<Vec<Row>, BakeError> {
        let table = parts::read_part(&run.folder, TEST, part.part, &run.facts())?;
        answered(field, &table)
    };
    let rows = plan.tests.par_iter().map(of_part);
    let rows = rows.collect::<Result<Vec<_>, BakeError>>()?.concat();
    if rows.len() < FEWEST as usize / 2 {
        return Ok(None);
    }
    let floor = epsilon(run.config.train.epsilon, plan.mean_luminance);
    let error = error(&rows, floor);
    Ok(Some(Tested {
        rows: rows.len() as u64,
        relative_error: error.relative(),
        relative_error_se: error.relative_se(),
    }))
}

/// What the model says of a point, and its two half estimates.
#[derive(Clone, Copy)]
struct Row {
    p: [f64; 3],
    halves: [[f32; 3]; 2],
}

impl Row {
    /// Mean of the halves.
    fn y(&self) -> [f64; 3] {
        let [a, b] = self.halves.map(|half| half.map(f64::from));
        [0, 1, 2].map(|c| 0.5 * (a[c] + b[c]))
    }

    /// Squared noise of that, a channel.
    fn noise(&self) -> f64 {
        let [a, b] = self.halves.map(|half| half.map(f64::from));
        (0..3).map(|c| (0.5 * (a[c] - b[c])).powi(2)).sum::<f64>() / 3.0
    }
}

/// The rows of a part with the field's answers, without those that are not finite.
fn answered(field: &Field, table: &SampleTable) -> Result<Vec<Row>, BakeError> {
    let mut rgb = [const { Vec::new() }; 3];
    field.evaluate(&table.columns, &mut rgb, &mut Vec::new())?;
    let [first, second] = &table.halves;
    let rows = first.iter().zip(second).enumerate();
    let rows = rows.map(|(i, (&first, &second))| Row {
        p: [0, 1, 2].map(|c| f64::from(rgb[c][i])),
        halves: [first, second],
    });
    let finite = |row: &Row| row.p.iter().chain(&row.y()).all(|x| x.is_finite());
    Ok(rows.filter(finite).collect())
}

/// Errors are divided by a mixture of target and prediction, each by the other's error, as in fits. It begins with
/// the prediction alone: targets of few paths in the divisor make errors of nothing but noise, 6σ⁴, which
/// would keep them there.
fn error(rows: &[Row], floor: f64) -> ErrorEstimate {
    let by = |share: f64| -> (ErrorEstimate, f64) {
        let divisor = |row: &Row| {
            let mixed = share * channel_mean(row.y()) + (1.0 - share) * channel_mean(row.p);
            1.0 / mixed.max(floor)
        };
        let value = |row: &Row| product(row.p, row.halves[0], row.halves[1], divisor(row));
        let values: Vec<f64> = rows.iter().map(value).collect();
        let noise = |row: &Row| row.noise() * divisor(row).powi(2);
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

/// Least error of a model that weighs it against the targets' noise.
const LEAST: f64 = 1e-3;
/// How often the mixture is made anew from the errors that it gives: the third changes nothing any more.
const RENEWALS: usize = 3;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::one_cell;
    use rrf_field::rng::{Stage, Stream};

    /// A sixteenth of the paths of the samples, at least a few rows, in draws that threads can share.
    #[test]
    fn in_proportion_to_the_samples() {
        let mut plan = one_cell(128);
        let [samples, tests] = spent(&plan);
        assert_eq!(samples, 6000.0 * 128.0);
        assert_eq!(
            tests,
            (FEWEST.max((6000.0 * SHARE / 4.0) as u32) * 4 * 128) as f64
        );
        plan.draws[0].rows = 1_000_000;
        keep_up(&mut plan, 128, 0.05, None);
        let [samples, tests] = spent(&plan);
        assert!((tests / samples / SHARE - 1.0).abs() < 0.001);
        assert!(
            plan.tests
                .iter()
                .all(|p| plan.draws[p.draw as usize].rows <= DRAW)
        );
        assert!((0u32..).zip(&plan.tests).all(|(n, p)| p.part == n));
        let before = plan.clone();
        plan.draws[0].rows = 1_100_000;
        let grown = plan.clone();
        keep_up(&mut plan, 128, 0.05, None);
        assert_eq!(plan, grown, "too few for files of their own");
        plan.draws[0].rows = 2_000_000;
        keep_up(&mut plan, 128, 0.05, Some(&judgement(0.07, 0.0009)));
        assert_eq!(plan.tests, before.tests, "those that there are tell enough");
        keep_up(&mut plan, 128, 0.05, Some(&judgement(0.07, 0.0011)));
        assert!(plan.tests.len() > before.tests.len());
    }

    fn judgement(relative_error: f64, relative_error_se: f64) -> Judgement {
        Judgement {
            relative_error: 0.0,
            relative_error_se: 0.0,
            test: Some(Tested {
                rows: 100,
                relative_error,
                relative_error_se,
            }),
            cells: Vec::new(),
        }
    }

    /// Twice as many where the target lies within the error's standard error, to a quarter of all.
    #[test]
    fn more_where_they_cannot_tell() {
        let mut plan = one_cell(128);
        let [samples, mut tests] = spent(&plan);
        assert!(more(&plan, 128, 0.05, &judgement(0.048, 0.001)).is_none());
        assert!(more(&plan, 128, 0.05, &judgement(0.06, 0.009)).is_none());
        let mut rounds = 0;
        while let Some(next) = more(&plan, 128, 0.05, &judgement(0.048, 0.003)) {
            assert_eq!((next.round, &next.cells), (plan.round + 1, &plan.cells));
            let [same, now] = spent(&next);
            assert!(same == samples && now > 1.2 * tests);
            (plan, tests, rounds) = (next, now, rounds + 1);
        }
        assert!(rounds > 0 && tests <= MOST * samples);
        assert!(2.0 * tests > MOST * samples);
    }

    /// A model a tenth too bright here and too dark there: the error comes out within three of its standard errors
    /// and 5 % for what the mixture in the divisor makes of it, however noisy the targets are; and so does one of none.
    #[test]
    fn noise_does_not_count() {
        let random = Stream::new(7, Stage::Test, 0);
        for (wrong, noise) in [(0.1, 0.2), (0.1, 0.5), (0.0, 0.2)] {
            let row = |i: u64| {
                let m = 2f64.powf(6.0 * random.f64(i, 0) - 3.0);
                let half = |d| m * (1.0 + noise * 12f64.sqrt() * (random.f64(i, d) - 0.5));
                let sign = if random.f64(i, 3) < 0.5 { -1.0 } else { 1.0 };
                Row {
                    p: [m * (1.0 + sign * wrong); 3],
                    halves: [half(1), half(2)].map(|y| [y as f32; 3]),
                }
            };
            let rows: Vec<Row> = (0..20_000).map(row).collect();
            let found = error(&rows, 1e-3);
            let square = wrong * wrong;
            let off = (found.square - square).abs();
            assert!(
                off < 3.0 * found.square_se + 0.05 * square,
                "{wrong}, {noise}: {found:?}"
            );
        }
    }
}
