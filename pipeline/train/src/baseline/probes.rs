//! A grid of irradiance probes: regularised least squares by conjugate gradients (CGLS; Hestenes,
//! Stiefel 1952; Björck 1996, sect. 7.4), the matrix never formed.

use super::solved::Solved;
use super::weighing::{Row, Weighing};
use crate::cell::Cell;
use crate::net::tile::CHANNELS;
use crate::rows::units::Input;
use rrf_field::columns::{L, N, P};
use rrf_field::probes::{Basis, Grid, HARMONICS, INPUTS};

/// Probes and light positions an axis.
pub(super) const GRID: Grid = Grid {
    places: 6,
    lights: 4,
};
/// Strengths tried: λ of ‖W (A x − y)‖² + λ² ‖x‖², outputs and errors in units of about one.
const RIDGES: [f64; 5] = [0.03, 0.1, 0.3, 1.0, 3.0];
/// Of each solution.
const EFFORT: Effort = Effort {
    steps: 60,
    enough: 1e-4,
};
/// Solutions, each from the last, after which the rows are weighed anew.
const PASSES: usize = 2;

type Rgb = [f64; CHANNELS];

/// When conjugate gradients end.
#[derive(Clone, Copy)]
struct Effort {
    /// After so many steps.
    steps: usize,
    /// Or where the gradient is this share of the first one.
    enough: f64,
}

/// Place, normal and light position, in steps of their grids over the box that the training rows span.
pub(super) fn inputs(cell: &Cell, grid: Grid) -> Vec<Input> {
    let columns = [P, N, L].map(|first| first..first + 3);
    let mut bounds = [(f32::INFINITY, f32::NEG_INFINITY); INPUTS];
    cell.raw.each(0..cell.train.len(), |chunk, rows| {
        for (column, (low, high)) in columns.iter().cloned().flatten().zip(&mut bounds) {
            for &x in chunk.columns.columns[column]
                .get(rows.clone())
                .unwrap_or_default()
            {
                (*low, *high) = (low.min(x), high.max(x));
            }
        }
    });
    let input = |(column, (low, high)): (usize, (f32, f32))| {
        let steps = match column {
            column if (N..N + 3).contains(&column) => None,
            column if column < N => Some(grid.places - 1),
            _ => Some(grid.lights - 1),
        };
        let scale = |steps: usize| steps as f32 / (high - low);
        let (offset, scale) = match steps {
            None => (0.0, 1.0),
            // a scene without extent along an axis: always the first probe
            Some(steps) => (
                low,
                Some(scale(steps)).filter(|s| s.is_finite()).unwrap_or(0.0),
            ),
        };
        Input {
            id: column as u8,
            offset,
            scale,
        }
    };
    columns
        .into_iter()
        .flatten()
        .zip(bounds)
        .map(input)
        .collect()
}

/// One candidate a ridge.
pub(super) fn solve(cell: &Cell) -> Vec<Solved> {
    let one = |ridge: f64| {
        let coefficients = solve_with(&mut Weighing::new(cell), GRID, ridge, EFFORT)?;
        Some(Solved {
            weights: coefficients.iter().flatten().map(|&w| w as f32).collect(),
            layers: vec![INPUTS, GRID.places, GRID.lights, CHANNELS],
            ridge,
        })
    };
    RIDGES.into_iter().filter_map(one).collect()
}

fn solve_with(weighing: &mut Weighing, grid: Grid, ridge: f64, effort: Effort) -> Option<Vec<Rgb>> {
    let mut found = vec![[0.0; CHANNELS]; grid.coefficients()?];
    for pass in 0..PASSES {
        if pass > 0 {
            weighing.reweigh(|row| outputs(&found, &basis(grid, row)));
        }
        System {
            weighing,
            grid,
            ridge,
        }
        .solve(&mut found, effort);
    }
    found
        .iter()
        .flatten()
        .all(|x| x.is_finite())
        .then_some(found)
}

fn basis(grid: Grid, row: &Row) -> Basis {
    grid.basis(std::array::from_fn(|i| {
        row.x.get(i).copied().unwrap_or(0.0)
    }))
}

/// A row of A times x, channel by channel.
fn outputs(x: &[Rgb], basis: &Basis) -> Rgb {
    let mut sum = [0.0; CHANNELS];
    for (&first, share) in basis.first.iter().zip(basis.share) {
        for (x, harmonic) in x[first..][..HARMONICS].iter().zip(basis.harmonics) {
            for (sum, x) in sum.iter_mut().zip(x) {
                *sum += share * harmonic * x;
            }
        }
    }
    sum
}

/// A row of Aᵀ times `y`, added.
fn spread(y: Rgb, basis: &Basis, sum: &mut [Rgb]) {
    for (&first, share) in basis.first.iter().zip(basis.share) {
        for (sum, harmonic) in sum[first..][..HARMONICS].iter_mut().zip(basis.harmonics) {
            for (sum, y) in sum.iter_mut().zip(y) {
                *sum += share * harmonic * y;
            }
        }
    }
}

/// The least squares of all channels side by side, under the weights as they are.
struct System<'a, 'b> {
    weighing: &'a Weighing<'b>,
    grid: Grid,
    ridge: f64,
}

impl System<'_, '_> {
    /// W (y − A x) of every row.
    fn residuals(&self, x: &[Rgb]) -> Vec<Rgb> {
        let mut residuals = Vec::with_capacity(self.weighing.len());
        self.weighing.each(|row| {
            let out = outputs(x, &basis(self.grid, row));
            residuals.push(std::array::from_fn(|c| {
                row.weight[c] * (row.target[c] - out[c])
            }));
        });
        residuals
    }

    /// W A x of every row.
    fn apply(&self, x: &[Rgb]) -> Vec<Rgb> {
        let mut applied = Vec::with_capacity(self.weighing.len());
        self.weighing.each(|row| {
            let out = outputs(x, &basis(self.grid, row));
            applied.push(std::array::from_fn(|c| row.weight[c] * out[c]));
        });
        applied
    }

    /// Aᵀ W r − λ² x.
    fn gradient(&self, residuals: &[Rgb], x: &[Rgb]) -> Vec<Rgb> {
        let mut sum: Vec<Rgb> = x
            .iter()
            .map(|x| x.map(|x| -self.ridge.powi(2) * x))
            .collect();
        self.weighing.each(|row| {
            let r = residuals.get(row.at).copied().unwrap_or_default();
            let weighted = std::array::from_fn(|c| row.weight[c] * r[c]);
            spread(weighted, &basis(self.grid, row), &mut sum);
        });
        sum
    }

    /// Conjugate gradients from `x` on.
    fn solve(&self, x: &mut [Rgb], effort: Effort) {
        let mut residuals = self.residuals(x);
        let mut gradient = self.gradient(&residuals, x);
        let mut direction = gradient.clone();
        let mut square = squares(&gradient);
        let first = square;
        for _ in 0..effort.steps {
            let applied = self.apply(&direction);
            let (image, length) = (squares(&applied), squares(&direction));
            let step: Rgb = std::array::from_fn(|c| {
                ratio(square[c], image[c] + self.ridge.powi(2) * length[c])
            });
            add(x, &direction, step);
            add(&mut residuals, &applied, step.map(|s| -s));
            gradient = self.gradient(&residuals, x);
            let before = std::mem::replace(&mut square, squares(&gradient));
            if (0..CHANNELS).all(|c| square[c] <= effort.enough.powi(2) * first[c]) {
                return;
            }
            let keep: Rgb = std::array::from_fn(|c| ratio(square[c], before[c]));
            for (d, g) in direction.iter_mut().zip(&gradient) {
                *d = std::array::from_fn(|c| g[c] + keep[c] * d[c]);
            }
        }
    }
}

/// Of a channel that is solved already, no step.
fn ratio(a: f64, b: f64) -> f64 {
    if b > 0.0 { a / b } else { 0.0 }
}

fn squares(x: &[Rgb]) -> Rgb {
    x.iter().fold([0.0; CHANNELS], |sum, x| {
        std::array::from_fn(|c| sum[c] + x[c] * x[c])
    })
}

fn add(x: &mut [Rgb], y: &[Rgb], step: Rgb) {
    for (x, y) in x.iter_mut().zip(y) {
        *x = std::array::from_fn(|c| x[c] + step[c] * y[c]);
    }
}

#[cfg(test)]
mod tests;
