//! Regression of a cell's radiance, and the cut of a cell that helps it most.
//!
//! A regression is no match for a net, but it is a thousand times cheaper, and where two, one a side,
//! leave much less than one over the whole, two nets do so too. Neither [`Rule`] is the better
//! one in all scenes (docs/science/report.md).

use ndarray::{Array2, ArrayView2, Axis, s};
use rrf_field::columns::{self, Columns};
use rrf_lm::Cholesky;

/// By what a cut is chosen.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize,
)]
pub enum Rule {
    /// Linear functions of log(radiance + ε): how bent the logarithm is along an axis, which is what
    /// nets with exponential outputs have to follow.
    Logarithm,
    /// Quadratic polynomials of the radiance, residuals relative to it: what is not smooth.
    Relative,
}

/// A cut of a cell in two.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Cut {
    /// Raw column.
    pub axis: usize,
    /// Rows below it go left.
    pub threshold: f32,
    /// Mean squared residual of one function over the whole cell.
    pub before: f64,
    /// The same of one a side.
    pub after: f64,
}

/// Share of the rows below a cut that is tried.
const QUANTILES: [f64; 5] = [0.25, 0.375, 0.5, 0.625, 0.75];
/// A cut moves to the middle of the widest gap between rows within this share of its quantile:
/// between two objects, two walls, or the two sides of one.
const SLACK: f64 = 0.06;
/// Ridge, as a share of the mean diagonal of the normal equations.
const RIDGE: f64 = 1e-8;
/// Columns that cells are cut along; a material's parameters vary within an object.
const AXES: std::ops::Range<usize> = 0..columns::GEOMETRY;
/// Rows looked at, at the most.
const MOST_ROWS: usize = 8192;

/// The cut that removes most, or none where no cut leaves `fewest` rows on both sides.
/// `halves` and `floor` (ε in radiance) as in [`crate::fit_cell`]; where not `glossy`, cuts along the
/// viewer's direction cannot help, and the base colour is divided out.
pub fn best_cut(
    rule: Rule,
    rows: &Columns,
    halves: [&[[f32; 3]]; 2],
    floor: f64,
    fewest: usize,
    glossy: bool,
) -> Option<Cut> {
    let [a, b] = halves;
    let usable: Vec<usize> = (0..rows.len().min(a.len()).min(b.len()))
        .filter(|&r| a[r].iter().chain(&b[r]).all(|y| y.is_finite()))
        .collect();
    let step = usable.len().div_ceil(MOST_ROWS).max(1);
    let usable: Vec<usize> = usable.into_iter().step_by(step).collect();
    let fewest = fewest.div_ceil(step).max(1);
    if usable.len() < 2 * fewest {
        return None;
    }
    let axes: Vec<usize> = AXES
        .filter(|c| glossy || !(columns::V..columns::L).contains(c))
        .filter(|&c| varies(&rows.columns[c], &usable))
        .collect();
    let mut features = features(rule, rows, &usable, &axes);
    let mut targets = targets(rows, halves, &usable, !glossy);
    let floor = floor.max(f64::MIN_POSITIVE);
    match rule {
        Rule::Logarithm => targets.mapv_inplace(|y| (y.max(0.0) + floor).ln()),
        Rule::Relative => {
            for (mut f, mut y) in features.rows_mut().into_iter().zip(targets.rows_mut()) {
                let weight = 1.0 / (y.sum() / 3.0).max(floor);
                f *= weight;
                y *= weight;
            }
        }
    }
    let rows_used = usable.len() as f64;
    let mut best: Option<Cut> = None;
    for &axis in &axes {
        let column: Vec<f32> = usable.iter().map(|&r| rows.columns[axis][r]).collect();
        let mut order: Vec<usize> = (0..column.len()).collect();
        order.sort_by(|&i, &j| column[i].total_cmp(&column[j]).then(i.cmp(&j)));
        let places = places(&column, &order, fewest);
        let sums = Sums::of_stretches(&features, &targets, &order, &places);
        let whole = sums
            .iter()
            .fold(Sums::zeros(&features), |all, s| all.plus(s));
        let before = whole.residual();
        let mut left = Sums::zeros(&features);
        for (&place, stretch) in places.iter().zip(&sums) {
            left = left.plus(stretch);
            let after = left.residual() + whole.minus(&left).residual();
            if best.is_none_or(|b| after < b.after * rows_used) {
                best = Some(Cut {
                    axis,
                    threshold: between(column[order[place - 1]], column[order[place]]),
                    before: before / rows_used,
                    after: after / rows_used,
                });
            }
        }
    }
    best
}

fn varies(column: &[f32], usable: &[usize]) -> bool {
    let (low, high) = usable
        .iter()
        .fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), &r| {
            (l.min(column[r]), h.max(column[r]))
        });
    // coordinates of a plane wobble by their rounding
    high - low > 1e-4 * low.abs().max(high.abs())
}

/// A threshold above `low` and not above `high`.
fn between(low: f32, high: f32) -> f32 {
    let middle = low + (high - low) * 0.5;
    if middle > low { middle } else { high }
}

/// Places in `order` to cut before, ascending; each at a gap of the column.
fn places(column: &[f32], order: &[usize], fewest: usize) -> Vec<usize> {
    let n = order.len();
    let gap = |i: usize| column[order[i]] - column[order[i - 1]];
    let slack = (n as f64 * SLACK) as usize;
    let mut places: Vec<usize> = QUANTILES
        .iter()
        .filter_map(|q| {
            let middle = (n as f64 * q) as usize;
            let low = middle.saturating_sub(slack).max(fewest).max(1);
            let high = (middle + slack).min(n - fewest);
            (low..=high)
                .filter(|&i| i < n && gap(i) > 0.0)
                .max_by(|&i, &j| {
                    let near = |k: usize| k.abs_diff(middle);
                    gap(i).total_cmp(&gap(j)).then(near(j).cmp(&near(i)))
                })
        })
        .collect();
    // wherever it is, the widest gap parts two objects
    let widest =
        (fewest.max(1)..n.saturating_sub(fewest)).max_by(|&i, &j| gap(i).total_cmp(&gap(j)));
    places.extend(widest.filter(|&i| gap(i) > 0.0));
    places.sort_unstable();
    places.dedup();
    places
}

/// 1, the standardised columns `axes` and, for quadratics, their products, shape [rows, terms].
fn features(rule: Rule, rows: &Columns, usable: &[usize], axes: &[usize]) -> Array2<f64> {
    let n = usable.len() as f64;
    let scaled: Vec<Vec<f64>> = axes
        .iter()
        .map(|&c| {
            let x = |r: &usize| f64::from(rows.columns[c][*r]);
            let mean = usable.iter().map(x).sum::<f64>() / n;
            let square = usable.iter().map(|r| (x(r) - mean).powi(2)).sum::<f64>() / n;
            let scale = 1.0 / square.sqrt().max(f64::MIN_POSITIVE);
            usable.iter().map(|r| (x(r) - mean) * scale).collect()
        })
        .collect();
    let mut terms = vec![vec![1.0; usable.len()]];
    terms.extend(scaled.iter().cloned());
    if rule == Rule::Relative {
        for (i, a) in scaled.iter().enumerate() {
            let product = |b: &Vec<f64>| a.iter().zip(b).map(|(a, b)| a * b).collect();
            terms.extend(scaled[i..].iter().map(product));
        }
    }
    Array2::from_shape_fn((usable.len(), terms.len()), |(row, term)| terms[term][row])
}

/// Radiance, the base colour divided out or not, shape [rows, 3].
fn targets(
    rows: &Columns,
    halves: [&[[f32; 3]]; 2],
    usable: &[usize],
    divide_base: bool,
) -> Array2<f64> {
    Array2::from_shape_fn((usable.len(), 3), |(i, c)| {
        let r = usable[i];
        let y = 0.5 * (f64::from(halves[0][r][c]) + f64::from(halves[1][r][c]));
        let base = f64::from(rows.columns[columns::BASE + c][r]);
        if divide_base && base > 0.0 {
            y / base
        } else {
            y
        }
    })
}

/// Normal equations of some rows: FᵀF, FᵀY and tr YᵀY.
#[derive(Clone)]
struct Sums {
    matrix: Array2<f64>,
    right: Array2<f64>,
    square: f64,
}

impl Sums {
    fn zeros(features: &Array2<f64>) -> Sums {
        let k = features.ncols();
        Sums {
            matrix: Array2::zeros((k, k)),
            right: Array2::zeros((k, 3)),
            square: 0.0,
        }
    }

    /// Of the rows before the first place, between the first and the second, and so on.
    fn of_stretches(
        features: &Array2<f64>,
        targets: &Array2<f64>,
        order: &[usize],
        places: &[usize],
    ) -> Vec<Sums> {
        let mut first = 0;
        let ends = places.iter().copied().chain([order.len()]);
        ends.map(|end| {
            let stretch = &order[first..end];
            first = end;
            let f = features.select(Axis(0), stretch);
            let y = targets.select(Axis(0), stretch);
            Sums {
                matrix: f.t().dot(&f),
                right: f.t().dot(&y),
                square: y.iter().map(|y| y * y).sum(),
            }
        })
        .collect()
    }

    fn plus(&self, other: &Sums) -> Sums {
        Sums {
            matrix: &self.matrix + &other.matrix,
            right: &self.right + &other.right,
            square: self.square + other.square,
        }
    }

    fn minus(&self, other: &Sums) -> Sums {
        Sums {
            matrix: &self.matrix - &other.matrix,
            right: &self.right - &other.right,
            square: self.square - other.square,
        }
    }

    /// Squared residuals of the best function, mean of the channels; all of the targets'
    /// where the equations have no solution.
    fn residual(&self) -> f64 {
        let explained =
            solve(self.matrix.view(), self.right.view()).map_or(0.0, |x| (&x * &self.right).sum());
        (self.square - explained).max(0.0) / 3.0
    }
}

/// (A + ridge) X = B.
fn solve(a: ArrayView2<f64>, b: ArrayView2<f64>) -> Option<Array2<f64>> {
    let k = a.nrows();
    let ridge = RIDGE * a.diag().sum() / k as f64;
    let mut factor = Cholesky::default();
    let matrix: Vec<f64> = a.iter().copied().collect();
    factor.factor(&matrix, &vec![ridge; k]).ok()?;
    let mut x = Array2::zeros(b.dim());
    for c in 0..b.ncols() {
        let mut column: Vec<f64> = b.slice(s![.., c]).to_vec();
        factor.solve(&mut column).ok()?;
        x.slice_mut(s![.., c])
            .iter_mut()
            .zip(column)
            .for_each(|(x, v)| *x = v);
    }
    Some(x)
}

#[cfg(test)]
mod tests;
