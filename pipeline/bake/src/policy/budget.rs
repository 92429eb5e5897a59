//! The work that fits into the rest of a time limit.

use crate::plan::round::RoundPlan;
use crate::plan::timings::Timings;
use crate::policy::cost;
use crate::policy::tasks::expected_rows;
use crate::settings::BakeConfig;
use std::time::Duration;

/// Share of the remaining time that a round is planned to take, since predictions are rough.
const CAREFUL: f64 = 0.92;

/// Core seconds, as predicted, that the next round may take if the ratio of measured to predicted
/// time stays that of this round, whose draws begin at `first_draw`; none where its time is unknown.
pub(crate) fn budget(
    config: &BakeConfig,
    plan: &RoundPlan,
    first_draw: usize,
    timings: &Timings,
    left: Duration,
) -> Option<f64> {
    if timings.extract + timings.train <= 0.0 {
        return None;
    }
    let draws = plan.draws.iter().skip(first_draw);
    let drawn: f64 = draws
        .map(|d| cost::draw_seconds(d.rows, d.paths, plan.path_seconds))
        .sum();
    let fitted = plan.cells.iter().zip(expected_rows(plan));
    let fitted = fitted.filter(|(cell, _)| cell.fitted == plan.round);
    let trained: f64 = fitted
        .map(|(cell, rows)| cost::fit_seconds(rows, cell, &config.train))
        .sum();
    Some(affordable(drawn + trained, timings, left))
}

/// Predicted seconds that fit into the remaining time where `predicted` seconds took `timings`.
fn affordable(predicted: f64, timings: &Timings, left: Duration) -> f64 {
    predicted * CAREFUL * left.as_secs_f64() / (timings.extract + timings.train)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten predicted seconds took five: 40 fit into the remaining 20, but for the margin.
    #[test]
    fn a_round_is_measured_by_the_one_before() {
        let timings = Timings {
            extract: 4.0,
            train: 1.0,
            evaluate: 7.0,
        };
        let fits = affordable(10.0, &timings, Duration::from_secs(20));
        assert!((fits - CAREFUL * 40.0).abs() < 1e-12, "{fits}");
        assert_eq!(affordable(10.0, &timings, Duration::ZERO), 0.0);
    }
}
