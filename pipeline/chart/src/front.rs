//! Runs of one setting together, and which settings nothing beats.

use crate::results::Row;
use std::collections::BTreeMap;

/// Mean over seeds and its standard error (0 for one seed).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Mean.
    pub mean: f64,
    /// Standard error of the mean.
    pub se: f64,
}

/// One setting over its seeds.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Column `method`.
    pub method: String,
    /// Column `setting`.
    pub setting: String,
    /// How many seeds.
    pub seeds: usize,
    /// The cost: seconds or bytes.
    pub cost: Estimate,
    /// The error.
    pub error: Estimate,
    /// Nothing else is both cheaper and better.
    pub on_front: bool,
}

/// A point a setting, ascending in cost; settings without this cost or error are left out.
pub fn points(
    rows: &[Row],
    cost: impl Fn(&Row) -> Option<f64>,
    error: impl Fn(&Row) -> Option<f64>,
) -> Vec<Point> {
    let mut settings: BTreeMap<(&str, &str), Vec<(f64, f64)>> = BTreeMap::new();
    for row in rows {
        if let (Some(cost), Some(error)) = (cost(row), error(row)) {
            let key = (row.method.as_str(), row.setting.as_str());
            settings.entry(key).or_default().push((cost, error));
        }
    }
    let mut points: Vec<Point> = settings
        .into_iter()
        .map(|((method, setting), runs)| Point {
            method: method.into(),
            setting: setting.into(),
            seeds: runs.len(),
            cost: estimate(runs.iter().map(|run| run.0)),
            error: estimate(runs.iter().map(|run| run.1)),
            on_front: false,
        })
        .collect();
    points.sort_by(|a, b| {
        (a.cost.mean.total_cmp(&b.cost.mean)).then(a.error.mean.total_cmp(&b.error.mean))
    });
    let mut best = f64::INFINITY;
    for point in &mut points {
        point.on_front = point.error.mean < best;
        best = best.min(point.error.mean);
    }
    points
}

fn estimate(values: impl Iterator<Item = f64> + Clone) -> Estimate {
    let n = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / n;
    let squares: f64 = values.map(|x| (x - mean).powi(2)).sum();
    let se = if n > 1.0 {
        (squares / (n - 1.0) / n).sqrt()
    } else {
        0.0
    };
    Estimate { mean, se }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rrf_sampling::{Stage, Stream};

    fn row(setting: &str, seed: u64, cost: f64, error: f64) -> Row {
        Row {
            method: "cells".into(),
            setting: setting.into(),
            seed,
            bake_seconds: Some(cost),
            frame_error: error,
            ..Row::default()
        }
    }

    fn of(rows: &[Row]) -> Vec<Point> {
        points(rows, |r| r.bake_seconds, |r| Some(r.frame_error))
    }

    /// Against the definition: on the front is what no other point dominates.
    #[test]
    fn the_front_is_what_nothing_dominates() {
        let random = Stream::new(3, Stage::Test, 0);
        let rows: Vec<Row> = (0..200)
            .map(|i| row(&format!("{i}"), 1, random.f64(i, 0), random.f64(i, 1)))
            .collect();
        let found = of(&rows);
        for p in &found {
            let dominated = found.iter().any(|q| {
                let no_worse = q.cost.mean <= p.cost.mean && q.error.mean <= p.error.mean;
                no_worse && (q.cost.mean < p.cost.mean || q.error.mean < p.error.mean)
            });
            assert_eq!(p.on_front, !dominated, "{p:?}");
        }
        assert!((2..100).contains(&found.iter().filter(|p| p.on_front).count()));
    }

    #[test]
    fn seeds_make_error_bars() {
        let rows = [
            row("a", 1, 1.0, 2.0),
            row("a", 2, 3.0, 4.0),
            row("b", 1, 9.0, 9.0),
        ];
        let found = of(&rows);
        assert_eq!((found.len(), found[0].seeds), (2, 2));
        // deviation sqrt(2), over sqrt(2) seeds
        let wanted = Estimate { mean: 3.0, se: 1.0 };
        assert!((found[0].error.se - wanted.se).abs() < 1e-15 && found[0].error.mean == 3.0);
        assert_eq!(found[1].error.se, 0.0);
    }

    #[test]
    fn what_has_no_cost_is_left_out() {
        let mut traced = row("spp=4", 1, 0.0, 1.0);
        traced.bake_seconds = None;
        assert!(of(&[traced]).is_empty() && of(&[]).is_empty());
    }
}
