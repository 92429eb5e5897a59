//! A basis of patch space for an ensemble of lights.
//!
//! TransferRows T and irradiances E of an ensemble give M = W T E: what the lights of the ensemble make
//! of the rows, weighted so that relative errors count. Its leading singular vectors U, S, V' say
//! which few combinations of patches matter:
//!
//! ```text
//! read = U' W T         rank x columns   coefficients of a light: c = read E
//! make = E V' S^-1      columns x rank   what a row is projected onto: t = T make
//! T E  ~ t c            = T (make read) E
//! ```
//!
//! make read is an oblique projector: it keeps what lights of the ensemble put in *and* rows take
//! out (balanced truncation, Moore 1981), where an orthogonal basis of E alone would spend its
//! dimensions on bright spots next to lights that no row sees.

mod cell;
mod svd;

use crate::TransferError;
use crate::entry::Entry;
use crate::rows::TransferRows;
use crate::tracing::Stream;
use glam::Vec3;
use ndarray::Array2;
use rayon::prelude::*;
use svd::leading;

pub use cell::CellBasis;

/// Combinations of rows by which a light's residual is measured.
pub(crate) const SKETCHES: usize = 32;
/// Singular values below this share of the largest are noise of the arithmetic.
const LEAST: f64 = 1e-7;

/// Weight of rows and lights: errors count relative to what a row usually gets.
#[derive(Clone, Debug)]
pub struct RelativeWeights {
    /// One a row [sr m^2/W].
    pub rows: Vec<f64>,
    /// One a light, without unit.
    pub lights: Vec<f64>,
}

/// Irradiance of every column under each light of an ensemble.
#[derive(Clone, Debug)]
pub struct Ensemble {
    /// How many lights.
    pub lights: usize,
    /// Shape [columns, lights], row-major [W/m^2]; of lights that shine alike in all channels.
    pub irradiance: Vec<f32>,
}

impl Ensemble {
    /// From each light's irradiance of all columns: the mean of its channels counts.
    pub fn new(lights: &[Vec<Vec3>]) -> Ensemble {
        let columns = lights.first().map_or(0, Vec::len);
        let mut irradiance = vec![0.0; columns * lights.len()];
        for (l, of) in lights.iter().enumerate() {
            for (c, e) in of.iter().enumerate() {
                irradiance[c * lights.len() + l] = e.element_sum() / 3.0;
            }
        }
        Ensemble {
            lights: lights.len(),
            irradiance,
        }
    }

    /// The mean over lights, every column.
    pub fn mean(&self) -> Vec<Vec3> {
        (self.irradiance.chunks_exact(self.lights.max(1)))
            .map(|of| Vec3::splat(of.iter().sum::<f32>() / self.lights.max(1) as f32))
            .collect()
    }

    fn row(&self, column: u32) -> &[f32] {
        let first = column as usize * self.lights;
        &self.irradiance[first..first + self.lights]
    }
}

/// The basis.
#[derive(Clone, Debug)]
pub struct Basis {
    /// Dimensions.
    pub rank: usize,
    /// Columns of the patches.
    pub columns: usize,
    /// Shape [columns, rank], row-major.
    pub make: Vec<f32>,
    /// Shape [rank, columns], row-major.
    pub read: Vec<f32>,
    /// Singular values, falling.
    pub values: Vec<f64>,
    /// Random combinations of weighted rows, shape [sketches, columns], and of their projections,
    /// [sketches, rank].
    pub(crate) sketch: Vec<f32>,
    pub(crate) sketch_made: Vec<f32>,
    /// Weights of the ensemble's lights, as [`RelativeWeights`] has them.
    pub lights: Vec<f64>,
}

/// What the lights of an ensemble make of rows: shape [3 rows, lights], channels of a row
/// together.
pub fn radiances(rows: &TransferRows, colours: &[Vec3], ensemble: &Ensemble) -> Array2<f64> {
    let lights = ensemble.lights;
    let values: Vec<f64> = (0..rows.len())
        .into_par_iter()
        .flat_map_iter(|row| {
            let mut sum = vec![0.0f32; 3 * lights];
            for (column, value) in mean_entries(rows, row, colours[row]) {
                let e = ensemble.row(column);
                for (channel, sum) in sum.chunks_exact_mut(lights.max(1)).enumerate() {
                    let value = value[channel];
                    sum.iter_mut().zip(e).for_each(|(s, e)| *s += value * e);
                }
            }
            sum.into_iter().map(f64::from)
        })
        .collect();
    Array2::from_shape_vec((3 * rows.len(), lights), values).unwrap_or_default()
}

/// Columns and values of a row, the mean of its halves, for a base colour.
fn mean_entries(
    rows: &TransferRows,
    row: usize,
    colour: Vec3,
) -> impl Iterator<Item = (u32, Vec3)> + use<'_> {
    (0..2).flat_map(move |half| {
        let (columns, entries) = rows.half(row, half);
        let value = move |e: &Entry| e.coloured(colour) * 0.5;
        columns
            .iter()
            .zip(entries)
            .map(move |(&c, e)| (c, value(e)))
    })
}

impl RelativeWeights {
    /// From radiances of shape [3 rows, lights]: a row's weight is 1 / max(its mean over lights,
    /// `floor` times the mean of all); a light's brings the mean weighted row to 1.
    pub fn new(radiances: &Array2<f64>, floor: f64) -> RelativeWeights {
        let (rows, lights) = (radiances.nrows() / 3, radiances.ncols());
        let means: Vec<f64> = (0..rows)
            .map(|row| {
                let three = (0..3)
                    .map(|c| radiances.row(3 * row + c).sum())
                    .sum::<f64>();
                three / (3 * lights).max(1) as f64
            })
            .collect();
        let all = means.iter().sum::<f64>() / rows.max(1) as f64;
        let least = (floor * all).max(f64::MIN_POSITIVE);
        let by_row: Vec<f64> = means.iter().map(|m| 1.0 / m.max(least)).collect();
        let by_light = (0..lights).map(|l| {
            let sum: f64 = (0..3 * rows)
                .map(|r| radiances[[r, l]] * by_row[r / 3])
                .sum();
            let mean = sum / (3 * rows).max(1) as f64;
            1.0 / mean.max(floor)
        });
        RelativeWeights {
            lights: by_light.collect(),
            rows: by_row,
        }
    }

    fn apply(&self, radiances: &mut Array2<f64>) {
        for ((r, l), x) in radiances.indexed_iter_mut() {
            *x *= self.rows[r / 3] * self.lights[l];
        }
    }
}

impl Basis {
    /// The basis of at most `rank` dimensions for rows with these base colours under an ensemble;
    /// `floor` as in [`RelativeWeights::new`].
    pub fn new(
        rows: &TransferRows,
        colours: &[Vec3],
        ensemble: &Ensemble,
        rank: usize,
        floor: f64,
        stream: Stream,
    ) -> Result<Basis, TransferError> {
        if rows.is_empty() || ensemble.lights == 0 || rank == 0 {
            return Err(TransferError::NoBasis {
                rows: rows.len(),
                lights: ensemble.lights,
                rank,
            });
        }
        let mut matrix = radiances(rows, colours, ensemble);
        let weights = RelativeWeights::new(&matrix, floor);
        weights.apply(&mut matrix);
        let found = leading(&matrix, rank, stream)?;
        let largest = found.values.first().copied().unwrap_or(0.0);
        let rank = found
            .values
            .iter()
            .filter(|&&v| v > LEAST * largest)
            .count();
        let columns = rows.width;
        let signs = |s: usize, r: usize| {
            let word = stream.part(1).block(r as u64, s as u32, 0)[0];
            if word & 1 == 0 { 1.0 } else { -1.0 }
        };
        let read = combined(rows, colours, &weights, rank, |k, r| found.left[[r, k]]);
        let sketch = combined(rows, colours, &weights, SKETCHES, signs);
        let mut make = vec![0.0f32; columns * rank];
        make.par_chunks_mut(rank.max(1))
            .enumerate()
            .for_each(|(c, make)| {
                let e = ensemble.row(c as u32);
                for (k, make) in make.iter_mut().enumerate() {
                    let right = found.right.row(k);
                    let products = e.iter().zip(&weights.lights).zip(right);
                    let sum: f64 = products.map(|((e, w), v)| f64::from(*e) * w * v).sum();
                    *make = (sum / found.values[k]) as f32;
                }
            });
        let mut basis = Basis {
            rank,
            columns,
            make,
            read,
            values: found.values.iter().take(rank).copied().collect(),
            sketch,
            sketch_made: Vec::new(),
            lights: weights.lights.clone(),
        };
        basis.sketch_made = (basis.sketch.chunks_exact(columns))
            .flat_map(|sketch| basis.projected(sketch.iter().copied().enumerate()))
            .collect();
        Ok(basis)
    }

    /// Columns -> rank: a row vector times `make`.
    fn projected(&self, row: impl Iterator<Item = (usize, f32)>) -> Vec<f32> {
        let mut sum = vec![0.0f32; self.rank];
        for (column, value) in row.filter(|(_, value)| *value != 0.0) {
            let make = &self.make[column * self.rank..(column + 1) * self.rank];
            sum.iter_mut().zip(make).for_each(|(s, m)| *s += value * m);
        }
        sum
    }

    /// One half of a row, projected: its coefficients' factors, `rank` entries.
    pub fn project(&self, rows: &TransferRows, row: usize, half: usize) -> Vec<Entry> {
        let (columns, entries) = rows.half(row, half);
        let mut sum = vec![Entry::default(); self.rank];
        for (&column, entry) in columns.iter().zip(entries) {
            let first = column as usize * self.rank;
            for (sum, &m) in sum.iter_mut().zip(&self.make[first..first + self.rank]) {
                sum.base += entry.base * m;
                sum.constant += entry.constant * m;
            }
        }
        sum
    }

    /// Coefficients of a light, `rank` numbers a channel, from its irradiance of all columns.
    pub fn coefficients(&self, irradiance: &[Vec3]) -> Result<Vec<Vec3>, TransferError> {
        self.check(irradiance)?;
        Ok(products(&self.read, self.columns, irradiance))
    }

    /// What share of the light that an irradiance sends into the rows the basis leaves out: the
    /// norm of the weighted rows' error over the norm of the weighted rows, estimated from random
    /// combinations of them (Johnson and Lindenstrauss 1984). 0 for a light of 0.
    pub fn residual(&self, irradiance: &[Vec3]) -> Result<f32, TransferError> {
        let coefficients = self.coefficients(irradiance)?;
        let whole = products(&self.sketch, self.columns, irradiance);
        let made = products(&self.sketch_made, self.rank, &coefficients);
        let (mut rest, mut all) = (0.0f64, 0.0f64);
        for (whole, made) in whole.iter().zip(&made) {
            rest += f64::from((*whole - *made).length_squared());
            all += f64::from(whole.length_squared());
        }
        Ok(if all > 0.0 {
            (rest / all).sqrt() as f32
        } else {
            0.0
        })
    }

    fn check(&self, irradiance: &[Vec3]) -> Result<(), TransferError> {
        if irradiance.len() == self.columns {
            return Ok(());
        }
        Err(TransferError::Columns {
            found: irradiance.len(),
            expected: self.columns,
        })
    }
}

/// A row-major matrix of `width` columns times a vector a channel.
fn products(matrix: &[f32], width: usize, vector: &[Vec3]) -> Vec<Vec3> {
    (matrix.par_chunks_exact(width.max(1)))
        .map(|row| {
            let mut sum = Vec3::ZERO;
            row.iter().zip(vector).for_each(|(m, v)| sum += *m * *v);
            sum
        })
        .collect()
}

/// `count` combinations of the weighted rows, channels apart; `factor(k, r)` is what
/// combination k takes of channel row r. Shape [count, columns].
fn combined(
    rows: &TransferRows,
    colours: &[Vec3],
    weights: &RelativeWeights,
    count: usize,
    factor: impl Fn(usize, usize) -> f64 + Sync,
) -> Vec<f32> {
    (0..count)
        .into_par_iter()
        .flat_map_iter(|k| {
            let mut sum = vec![0.0f64; rows.width];
            for (row, (&colour, &weight)) in colours.iter().zip(&weights.rows).enumerate() {
                let by = [0, 1, 2].map(|c| factor(k, 3 * row + c) * weight);
                for (column, value) in mean_entries(rows, row, colour) {
                    let parts = (0..3).map(|c| by[c] * f64::from(value[c]));
                    sum[column as usize] += parts.sum::<f64>();
                }
            }
            sum.into_iter().map(|x| x as f32)
        })
        .collect()
}
