//! An ensemble of lights, and how rows and lights are weighed by each other.

use crate::entry::Entry;
use crate::rows::TransferRows;
use glam::Vec3;
use ndarray::Array2;
use rayon::prelude::*;

/// Weight of rows and lights: errors count relative to what a row usually gets, and to what a
/// light usually gives.
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

    /// Every light on one column.
    #[inline]
    pub(crate) fn row(&self, column: u32) -> &[f32] {
        let first = column as usize * self.lights;
        &self.irradiance[first..first + self.lights]
    }
}

/// Radiances of rows under the lights of an ensemble: shape [3 rows, lights], channels of a row
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
    /// From radiances of shape [3 rows, lights], each light being scaled to a mean of 1 first: a row's
    /// weight is 1 / max(its mean over lights, `floor`); a light's brings the mean of the weighted
    /// rows to one. A light that gives less than `floor` of what the median light does counts as if it gave
    /// that.
    pub fn new(radiances: &Array2<f64>, floor: f64) -> RelativeWeights {
        let (rows, lights) = (radiances.nrows() / 3, radiances.ncols());
        let inverse = |mean: f64| if mean > 0.0 { 1.0 / mean } else { 0.0 };
        let channel_rows = radiances.nrows().max(1) as f64;
        let gives: Vec<f64> = (0..lights)
            .map(|l| radiances.column(l).sum() / channel_rows)
            .collect();
        let mut sorted = gives.clone();
        sorted.sort_by(f64::total_cmp);
        let usual = sorted.get(lights / 2).copied().unwrap_or(0.0);
        let scales: Vec<f64> = (gives.iter())
            .map(|mean| inverse(mean.max(floor * usual)))
            .collect();
        let lit = gives.iter().filter(|&&g| g > 0.0).count().max(1) as f64;
        let by_row: Vec<f64> = (0..rows)
            .map(|row| {
                let sum: f64 = (3 * row..3 * row + 3)
                    .map(|r| {
                        radiances
                            .row(r)
                            .iter()
                            .zip(&scales)
                            .map(|(x, s)| x * s)
                            .sum::<f64>()
                    })
                    .sum();
                1.0 / (sum / (3.0 * lit)).max(floor)
            })
            .collect();
        let by_light = (0..lights).map(|l| {
            let sum: f64 = (0..3 * rows)
                .map(|r| radiances[[r, l]] * by_row[r / 3])
                .sum();
            let counted = gives[l] * inverse(gives[l].max(floor * usual));
            inverse(sum / channel_rows) * counted
        });
        RelativeWeights {
            lights: by_light.collect(),
            rows: by_row,
        }
    }
}
