//! The judges of the oracle tables: `tests/data/oracle/judge_points.py`, written again, and
//! proofs that they can say no.

use crate::table::Table;
use std::collections::BTreeMap;

/// Radiance of an oracle table: mean and standard error a row, and what its rows are grouped by.
pub struct Oracle {
    pub mean: Vec<[f64; 3]>,
    pub error: Vec<[f64; 3]>,
    /// Material and quadrant of the light: geometry alone, never the values.
    group: Vec<(String, bool, bool)>,
}

impl Oracle {
    pub fn read(path: &str) -> Oracle {
        let table = Table::read(path);
        let above = |name| {
            let values = table.numbers(name);
            let middle = median(&values);
            values.into_iter().map(move |x| x > middle)
        };
        let quadrants = above("lx").zip(above("lz"));
        let materials = table.names("material").into_iter();
        Oracle {
            mean: table.rgb(""),
            error: table.rgb("_se"),
            group: materials
                .zip(quadrants)
                .map(|(m, (x, z))| (m, x, z))
                .collect(),
        }
    }

    /// Relative error of a model, and its standard error:
    /// sqrt(mean((p-m)² / max(lum(m), ε)²)), ε = 5 % of the mean luminance. m is known up to its
    /// standard error s: E[(p - m)²] = (p - truth)² + s², so s² is taken out.
    pub fn relative_error(&self, model: &[[f64; 3]]) -> (f64, f64) {
        assert_eq!(model.len(), self.mean.len(), "rows");
        let luminance = |m: &[f64; 3]| (m[0] + m[1] + m[2]) / 3.0;
        let rows = self.mean.len() as f64;
        let floor = 0.05 * self.mean.iter().map(luminance).sum::<f64>() / rows;
        let squares: Vec<f64> = (0..model.len())
            .map(|row| {
                let (p, m, s) = (model[row], self.mean[row], self.error[row]);
                let square = (0..3).map(|c| (p[c] - m[c]).powi(2) - s[c] * s[c]);
                square.sum::<f64>() / 3.0 / luminance(&m).max(floor).powi(2)
            })
            .collect();
        let mean = squares.iter().sum::<f64>() / rows;
        let variance = squares.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / rows;
        let relative = mean.max(0.0).sqrt();
        (
            relative,
            (variance / rows).sqrt() / (2.0 * relative).max(1e-9),
        )
    }

    /// Compares two Monte Carlo estimates by sums over groups of rows: single rows are skewed,
    /// their standard error goes with their mean.
    pub fn agreement(&self, mean: &[[f64; 3]], error: &[[f64; 3]]) -> Agreement {
        assert_eq!(
            (mean.len(), error.len()),
            (self.mean.len(), self.mean.len()),
            "rows"
        );
        let mut groups: BTreeMap<&(String, bool, bool), Vec<usize>> = BTreeMap::new();
        for (row, group) in self.group.iter().enumerate() {
            groups.entry(group).or_default().push(row);
        }
        let sum_z = |rows: &[usize], c: usize| {
            let (mut difference, mut variance) = (0.0, 0.0);
            for &row in rows {
                difference += mean[row][c] - self.mean[row][c];
                variance += error[row][c].powi(2) + self.error[row][c].powi(2);
            }
            difference / f64::sqrt(variance)
        };
        let z: Vec<f64> = groups
            .values()
            .filter(|rows| rows.len() >= 10)
            .flat_map(|rows| [0, 1, 2].map(|c| sum_z(rows, c)))
            .collect();
        let all: Vec<usize> = (0..mean.len()).collect();
        let total = |values: &[[f64; 3]]| values.iter().flatten().sum::<f64>();
        let far = all
            .iter()
            .flat_map(|&row| [0, 1, 2].map(|c| sum_z(&[row], c)));
        Agreement {
            groups: z.len(),
            mean_square: z.iter().map(|z| z * z).sum::<f64>() / z.len() as f64,
            greatest: z.iter().fold(0.0, |m, z| z.abs().max(m)),
            whole: [0, 1, 2].map(|c| sum_z(&all, c)),
            bias: total(mean) / total(&self.mean) - 1.0,
            far: far.filter(|z| z.abs() > 4.0).count() as f64 / (3 * all.len()) as f64,
        }
    }
}

/// How two estimates of the same table compare.
#[derive(Debug)]
pub struct Agreement {
    /// Groups times channels.
    pub groups: usize,
    /// Mean of the groups' z²; 1 is expected.
    pub mean_square: f64,
    /// Greatest |z| of a group.
    pub greatest: f64,
    /// z of the sum over all rows, by channel.
    pub whole: [f64; 3],
    /// Relative difference of the sums over all rows and channels.
    pub bias: f64,
    /// Share of single values beyond 4 standard errors.
    pub far: f64,
}

impl Agreement {
    pub fn passes(&self) -> bool {
        self.groups >= 30
            && self.mean_square < 2.2
            && self.greatest < 5.0
            && self.whole.iter().all(|z| z.abs() < 4.0)
            && self.bias.abs() < 0.02
            && self.far < 0.005
    }
}

fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len();
    (sorted[(n - 1) / 2] + sorted[n / 2]) / 2.0
}

/// The table against itself passes; with one wall 5 % too dark, or everything 2.5 % too bright,
/// it does not.
#[test]
fn agreement_can_say_no() {
    let oracle = Oracle::read(&crate::program::oracle("cornell_overhead"));
    let scaled = |factor: &dyn Fn(usize) -> f64| {
        let rows = oracle.mean.iter().enumerate();
        let mean: Vec<[f64; 3]> = rows.map(|(row, m)| m.map(|x| x * factor(row))).collect();
        oracle.agreement(&mean, &oracle.error)
    };
    assert!(scaled(&|_| 1.0).passes());
    let wall = oracle.group[0].0.clone();
    let dark = |row: usize| {
        if oracle.group[row].0 == wall {
            0.95
        } else {
            1.0
        }
    };
    assert!(!scaled(&dark).passes(), "{wall}: {:?}", scaled(&dark));
    assert!(!scaled(&|_| 1.025).passes(), "{:?}", scaled(&|_| 1.025));
}

/// A model that is 10 % too bright everywhere has a relative error of 0.1 times the root mean
/// square of m / max(lum(m), ε), less the table's noise; one that knows only the mean colour has
/// far more than any limit in use.
#[test]
fn relative_error_is_what_it_says() {
    let oracle = Oracle::read(&crate::program::oracle("cornell_overhead"));
    let rows = oracle.mean.len() as f64;
    let mean = [0, 1, 2].map(|c| oracle.mean.iter().map(|m| m[c]).sum::<f64>() / rows);
    let (constant, _) = oracle.relative_error(&vec![mean; oracle.mean.len()]);
    assert!(constant > 0.5, "{constant}");
    let brighter: Vec<[f64; 3]> = oracle.mean.iter().map(|m| m.map(|x| 1.1 * x)).collect();
    let luminance = |m: &[f64; 3]| (m[0] + m[1] + m[2]) / 3.0;
    let floor = 0.05 * (mean[0] + mean[1] + mean[2]) / 3.0;
    let square: f64 = oracle
        .mean
        .iter()
        .zip(&oracle.error)
        .map(|(m, s)| {
            let divisor = luminance(m).max(floor).powi(2);
            (0..3)
                .map(|c| (0.1 * m[c]).powi(2) - s[c] * s[c])
                .sum::<f64>()
                / 3.0
                / divisor
        })
        .sum();
    let (found, _) = oracle.relative_error(&brighter);
    assert!((found - (square / rows).sqrt()).abs() < 1e-9, "{found}");
}
