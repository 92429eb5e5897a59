//! Time that a bake still needs, from the errors of its rounds.

use std::time::{Duration, Instant};

/// Rounds that a forecast looks back on.
const LATEST: usize = 4;

/// The rounds of a bake so far, and where it is to get.
#[derive(Debug)]
pub struct Forecast {
    begun: Instant,
    target: f64,
    /// Seconds since the beginning and relative error, a round each.
    rounds: Vec<(f64, f64)>,
}

impl Forecast {
    /// A bake that begins now and ends at a relative error of `target`.
    pub fn new(target: f64) -> Forecast {
        Forecast {
            begun: Instant::now(),
            target,
            rounds: Vec::new(),
        }
    }

    /// A round has ended with a relative error.
    pub fn add(&mut self, error: f64) {
        self.rounds
            .push((self.begun.elapsed().as_secs_f64(), error));
    }

    /// Time left until the target, if the error goes on falling as a power of time as it did over the last rounds;
    /// none before the second round, and where it does not fall.
    pub fn left(&self) -> Option<Duration> {
        let from = self.rounds.len().saturating_sub(LATEST);
        let end = reaches(&self.rounds[from..], self.target)?;
        let left = end - self.begun.elapsed().as_secs_f64();
        Duration::try_from_secs_f64(left.max(0.0)).ok()
    }
}

/// Seconds at which the line of least squares through the logarithms of time and error reaches `target`, drawn
/// through the last round.
fn reaches(rounds: &[(f64, f64)], target: f64) -> Option<f64> {
    let logarithms = rounds
        .iter()
        .map(|&(seconds, error)| (seconds.ln(), error.ln()));
    let points: Vec<(f64, f64)> = logarithms
        .filter(|(x, y)| x.is_finite() && y.is_finite())
        .collect();
    let count = points.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / count;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let products: f64 = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    let squares: f64 = points.iter().map(|p| (p.0 - x).powi(2)).sum();
    let &(last_x, last_y) = points.last().filter(|_| points.len() > 1)?;
    let slope = products / squares;
    (slope < 0.0).then(|| (last_x + (target.ln() - last_y) / slope).exp())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Errors of 1 / sqrt(seconds): 5 % after 400 s.
    #[test]
    fn a_power_law_is_followed_to_the_target() {
        let rounds: Vec<(f64, f64)> = [10.0f64, 25.0, 60.0, 100.0]
            .map(|seconds| (seconds, seconds.powf(-0.5)))
            .to_vec();
        let end = reaches(&rounds, 0.05).unwrap();
        assert!((end - 400.0).abs() < 1e-6, "{end}");
    }

    #[test]
    fn nothing_is_forecast_from_one_round_or_from_errors_that_do_not_fall() {
        assert_eq!(reaches(&[], 0.05), None);
        assert_eq!(reaches(&[(10.0, 0.2)], 0.05), None);
        assert_eq!(reaches(&[(10.0, 0.2), (20.0, 0.2)], 0.05), None);
        assert_eq!(reaches(&[(10.0, 0.2), (20.0, 0.3)], 0.05), None);
        assert_eq!(reaches(&[(10.0, 0.2), (20.0, 0.0)], 0.05), None);
    }
}
