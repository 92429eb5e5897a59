//! From a cell's rows to what a net is trained on: quarantine, inputs, scales.

use crate::config::TrainConfig;
use crate::error::TrainError;
use crate::tile::CHANNELS;
use rrf_field::columns::{self, Columns};
use rrf_field::model::{self, INPUTS};

/// A cell's samples as they come in.
#[derive(Clone, Copy)]
pub struct Samples<'a> {
    /// Geometry and material.
    pub rows: &'a Columns,
    /// Two independent estimates of the radiance of each row, W·sr⁻¹·m⁻².
    pub halves: [&'a [[f32; 3]]; 2],
    /// Whether a row is kept back for validation.
    pub validation: &'a [bool],
}

impl Samples<'_> {
    /// All lengths agree.
    pub fn check(&self) -> Result<(), TrainError> {
        let expected = self.rows.len();
        let lengths = [
            ("half 1", self.halves[0].len()),
            ("half 2", self.halves[1].len()),
            ("validation", self.validation.len()),
        ];
        for (what, found) in lengths {
            if found != expected {
                return Err(TrainError::Length {
                    what,
                    found,
                    expected,
                });
            }
        }
        for (name, column) in columns::NAMES.iter().zip(&self.rows.columns) {
            if column.len() != expected {
                return Err(TrainError::Length {
                    what: name,
                    found: column.len(),
                    expected,
                });
            }
        }
        Ok(())
    }

    /// Mean of the two halves.
    pub fn mean(&self, row: usize) -> [f64; CHANNELS] {
        let (a, b) = (self.halves[0][row], self.halves[1][row]);
        std::array::from_fn(|c| 0.5 * (f64::from(a[c]) + f64::from(b[c])))
    }

    /// Base colour where the target is divided by it, otherwise 1.
    pub fn base(&self, row: usize, divide: bool) -> [f64; CHANNELS] {
        if divide {
            self.rows.vec3(columns::BASE, row).map(f64::from)
        } else {
            [1.0; CHANNELS]
        }
    }
}

/// Mean of the channels.
pub fn luminance(y: [f64; CHANNELS]) -> f64 {
    y.iter().sum::<f64>() / CHANNELS as f64
}

/// An input, its column and its scale.
pub struct Input {
    /// Place in [`INPUTS`].
    pub id: u8,
    /// One value a row of the cell.
    pub values: Vec<f32>,
    /// Mean over the training rows.
    pub offset: f32,
    /// 1 / standard deviation over the training rows.
    pub scale: f32,
}

/// Whether the light over the base colour of a Lambertian point can depend on an input: not on
/// the viewer, not on the material.
fn matters_to_lambert(id: u8) -> bool {
    let column = usize::from(id);
    let viewer = (columns::V..columns::L).contains(&column)
        || matches!(INPUTS.get(column), Some(&"mirror_light" | &"cos_view"));
    !viewer && !(columns::BASE..columns::COUNT).contains(&column)
}

/// Inputs named in the configuration that can matter, in its order, and those that cannot.
pub fn choose_inputs(config: &TrainConfig) -> Result<(Vec<u8>, Vec<u8>), TrainError> {
    let named = input_ids(config)?;
    Ok(named
        .into_iter()
        .partition(|&id| !config.divide_base || matters_to_lambert(id)))
}

fn input_ids(config: &TrainConfig) -> Result<Vec<u8>, TrainError> {
    let find = |name: &String| {
        let place = INPUTS.iter().position(|known| known == name);
        place.map(|p| p as u8).ok_or_else(|| TrainError::Input {
            name: name.clone(),
            known: INPUTS.join(", "),
        })
    };
    config.inputs.iter().map(find).collect()
}

/// Computes the inputs for all rows.
pub fn compute_inputs(ids: &[u8], rows: &Columns) -> Vec<Input> {
    ids.iter()
        .map(|&id| {
            let mut values = Vec::new();
            model::fill(id, rows, &mut values);
            Input {
                id,
                values,
                offset: 0.0,
                scale: 1.0,
            }
        })
        .collect()
}

/// Rows in which a used number is NaN or infinite, or a base colour negative.
pub fn quarantine(samples: &Samples, inputs: &[Input], divide_base: bool) -> Vec<u32> {
    let bad = |row: usize| {
        let finite = |y: [f32; 3]| y.iter().all(|y| y.is_finite());
        let base = samples.rows.vec3(columns::BASE, row);
        !(finite(samples.halves[0][row]) && finite(samples.halves[1][row]))
            || inputs.iter().any(|input| !input.values[row].is_finite())
            || (divide_base && !base.iter().all(|b| *b >= 0.0 && b.is_finite()))
    };
    (0..samples.rows.len())
        .filter(|&row| bad(row))
        .map(|row| row as u32)
        .collect()
}

/// Scales the inputs over `train` and takes out those that do not vary there: those whose
/// standard deviation is below 1e-5 of the largest absolute value among the coordinates they
/// belong with (f32 coordinates of a plane wobble by 1e-7 of that).
pub fn scale_inputs(inputs: &mut Vec<Input>, train: &[u32]) -> Vec<u8> {
    let largest = |input: &Input| {
        train
            .iter()
            .map(|&r| f64::from(input.values[r as usize]).abs())
            .fold(0.0, f64::max)
    };
    let sizes: Vec<(u8, f64)> = inputs.iter().map(|i| (i.id, largest(i))).collect();
    let mut dropped = Vec::new();
    inputs.retain_mut(|input| {
        let family = sizes
            .iter()
            .filter(|(id, _)| same_family(*id, input.id))
            .map(|(_, size)| *size)
            .fold(0.0, f64::max);
        let n = train.len().max(1) as f64;
        let values = || train.iter().map(|&r| f64::from(input.values[r as usize]));
        let mean = values().sum::<f64>() / n;
        let deviation = (values().map(|x| (x - mean) * (x - mean)).sum::<f64>() / n).sqrt();
        let (offset, scale) = (mean as f32, (1.0 / deviation) as f32);
        // An f32 scale underflows for spreads beyond 1e38: such an input cannot be stored.
        let keep = deviation > 1e-5 * family && scale.is_normal() && offset.is_finite();
        if keep {
            (input.offset, input.scale) = (offset, scale);
        } else {
            dropped.push(input.id);
        }
        keep
    });
    dropped
}

/// Coordinates of one vector in one unit; every other input stands alone.
fn same_family(a: u8, b: u8) -> bool {
    let family = |id: u8| match id as usize {
        i @ 0..15 => i / 3,
        18..21 => 100,
        i => 200 + i,
    };
    family(a) == family(b)
}

/// Scale and offset of the output channels, in units of radiance (or radiance over base).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutputScale {
    /// Multiplied onto net outputs.
    pub scale: [f32; CHANNELS],
    /// Added after that.
    pub offset: [f32; CHANNELS],
    /// Whether the target is the same in all rows.
    pub constant: bool,
}

/// Mean and standard deviation of the targets over `rows`, each row weighted by
/// 1 / max(luminance, floor)²; for `exponential` outputs the mean as scale and no offset.
pub fn scale_outputs(
    samples: &Samples,
    rows: &[u32],
    floor: f64,
    divide: bool,
    exponential: bool,
) -> OutputScale {
    let mut out = OutputScale {
        scale: [1.0; CHANNELS],
        offset: [0.0; CHANNELS],
        constant: true,
    };
    for c in 0..CHANNELS {
        let values: Vec<(f64, f64)> = (rows.iter())
            .map(|&r| {
                let base = samples.base(r as usize, divide)[c];
                let y = samples.mean(r as usize);
                (base / luminance(y).max(floor), y[c] / base)
            })
            .filter(|(weight, _)| *weight > 0.0)
            .collect();
        let weight: f64 = values.iter().map(|(w, _)| w * w).sum();
        out.scale[c] = if exponential { 0.0 } else { 1.0 };
        if weight == 0.0 || !weight.is_finite() {
            continue;
        }
        let mean = values.iter().map(|(w, y)| w * w * y).sum::<f64>() / weight;
        let spread: f64 = values.iter().map(|(w, y)| (w * (y - mean)).powi(2)).sum();
        let deviation = (spread / weight).sqrt();
        let varies = deviation > 1e-7 * mean.abs() && (deviation as f32).is_normal();
        out.constant &= !varies;
        if exponential {
            // A channel without light gets scale 0, which takes it out of the fit.
            out.scale[c] = mean.max(0.0) as f32;
        } else {
            out.offset[c] = mean as f32;
            out.scale[c] = if varies { deviation as f32 } else { 1.0 };
        }
    }
    out
}

/// The noise of the targets, told by the difference of two independent halves: half of it has
/// the variance of their mean.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Noise {
    /// Mean squared noise relative to max(luminance, floor), over rows and channels.
    pub square: f64,
    /// How many times the channels count the same noise: 1 where independent, 3 where equal.
    /// With C the covariance of the channels' noise, 3 ‖C‖² / (tr C)².
    pub overcount: f64,
}

/// Noise over `rows`.
pub fn noise(samples: &Samples, rows: &[u32], floor: f64) -> Noise {
    let mut covariance = [[0.0; CHANNELS]; CHANNELS];
    for &row in rows {
        let d = 0.5 / luminance(samples.mean(row as usize)).max(floor);
        let [a, b] = samples.halves.map(|half| half[row as usize].map(f64::from));
        let e: [f64; CHANNELS] = std::array::from_fn(|c| d * (a[c] - b[c]));
        for (i, row) in covariance.iter_mut().enumerate() {
            for (j, sum) in row.iter_mut().enumerate() {
                *sum += e[i] * e[j];
            }
        }
    }
    let trace: f64 = (0..CHANNELS).map(|c| covariance[c][c]).sum();
    let norm: f64 = covariance.iter().flatten().map(|c| c * c).sum();
    Noise {
        square: trace / (CHANNELS * rows.len().max(1)) as f64,
        overcount: if trace > 0.0 {
            CHANNELS as f64 * norm / (trace * trace)
        } else {
            1.0
        },
    }
}
