//! From a cell's rows to what a net is trained on: quarantine, inputs, scales.

use crate::config::TrainConfig;
use crate::error::TrainError;
use crate::ordered::Ordered;
use crate::place::{self, What};
use crate::tile::CHANNELS;
use rrf_field::columns::{self, Columns};
use rrf_field::model::{self, INPUTS};
use std::ops::Range;

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
}

/// Mean of the channels.
pub fn luminance(y: [f64; CHANNELS]) -> f64 {
    y.iter().sum::<f64>() / CHANNELS as f64
}

/// An input and its scale.
#[derive(Clone, Debug, PartialEq)]
pub struct Input {
    /// Place in [`INPUTS`].
    pub id: u8,
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

/// Inputs named in the configuration that a cell gets, in its order, and those that it does without.
pub(crate) fn choose_inputs(config: &TrainConfig) -> Result<(Vec<u8>, Vec<u8>), TrainError> {
    let named = input_ids(config)?;
    Ok(named
        .into_iter()
        .partition(|&id| !config.divide_base || matters_to_lambert(id)))
}

/// Normal and material, where they are asked for beside a place that tells them, and the inputs that are left.
pub(crate) fn told_by_place(
    ids: Vec<u8>,
    rows: &Ordered,
    train: Range<usize>,
) -> (Vec<u8>, Vec<u8>) {
    let whole_place = (columns::P..columns::N).all(|c| ids.contains(&(c as u8)));
    let told: Vec<What> = [What::Normal, What::Material]
        .into_iter()
        .filter(|what| {
            let asked_for = |id: &u8| what.columns().contains(&usize::from(*id));
            whole_place && ids.iter().any(asked_for) && place::tells(*what, rows, train.clone())
        })
        .collect();
    ids.into_iter().partition(|&id| {
        told.iter()
            .any(|what| what.columns().contains(&usize::from(id)))
    })
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

/// Which rows hold a used number that is NaN or infinite, or a negative base colour.
pub(crate) fn unusable(samples: &Samples, ids: &[u8], divide_base: bool) -> Vec<bool> {
    let finite = |y: [f32; 3]| y.iter().all(|y| y.is_finite());
    let bad = |row: usize| {
        let base = samples.rows.vec3(columns::BASE, row);
        !(finite(samples.halves[0][row]) && finite(samples.halves[1][row]))
            || (divide_base && !base.iter().all(|b| *b >= 0.0 && b.is_finite()))
    };
    let mut unusable: Vec<bool> = (0..samples.rows.len()).map(bad).collect();
    let mut values = Vec::new();
    for &id in ids {
        model::fill(id, samples.rows, &mut values);
        for (bad, x) in unusable.iter_mut().zip(&values) {
            *bad |= !x.is_finite();
        }
    }
    unusable
}

/// Hands on an input's values over some rows, in order.
fn each_value(id: u8, rows: &Ordered, range: Range<usize>, mut see: impl FnMut(f64)) {
    let mut values = Vec::new();
    rows.each(range, |chunk, rows| {
        model::fill(id, &chunk.columns, &mut values);
        values[rows].iter().for_each(|x| see(f64::from(*x)));
    });
}

/// The inputs `ids` scaled over the training rows `train`, and those that do not vary there:
/// whose standard deviation is below [`WOBBLE`] of the largest absolute value among the coordinates
/// they belong with (f32 coordinates of a plane wobble by 1e-7 of that).
///
/// In a `lambert` cell also those that differ from their usual value in fewer than [`FEWEST`] rows. A
/// strip of wall in a cell of floor is a few rows, many deviations away: points there would get
/// whatever a net makes of such inputs, and shine. Where materials are glossy such a strip may be
/// ten times as dark as its cell; even three rows are then better than none (docs/accuracy.md).
pub(crate) fn scale_inputs(
    ids: &[u8],
    rows: &Ordered,
    train: Range<usize>,
    lambert: bool,
) -> (Vec<Input>, Vec<u8>) {
    let n = train.len().max(1) as f64;
    // largest absolute value, mean
    let sized: Vec<(u8, f64, f64)> = (ids.iter())
        .map(|&id| {
            let (mut largest, mut sum) = (0.0f64, 0.0);
            each_value(id, rows, train.clone(), |x| {
                largest = largest.max(x.abs());
                sum += x;
            });
            (id, largest, sum / n)
        })
        .collect();
    let (mut inputs, mut dropped) = (Vec::new(), Vec::new());
    for &(id, _, mean) in &sized {
        let family = (sized.iter())
            .filter(|(other, ..)| same_family(*other, id))
            .map(|(_, size, _)| *size)
            .fold(0.0, f64::max);
        let usual = usual(id, rows, train.clone());
        let (mut squares, mut differ) = (0.0, 0);
        each_value(id, rows, train.clone(), |x| {
            squares += (x - mean) * (x - mean);
            differ += usize::from((x - usual).abs() > WOBBLE * family);
        });
        let deviation = (squares / n).sqrt();
        let (offset, scale) = (mean as f32, (1.0 / deviation) as f32);
        // An f32 scale underflows for spreads beyond 1e38: such an input cannot be stored.
        let varies = deviation > WOBBLE * family && !(lambert && differ < FEWEST);
        if varies && scale.is_normal() && offset.is_finite() {
            inputs.push(Input { id, offset, scale });
        } else {
            dropped.push(id);
        }
    }
    (inputs, dropped)
}

/// Share of the largest coordinate that rounding makes.
const WOBBLE: f64 = 1e-5;
/// Rows that have to differ.
const FEWEST: usize = 5;
/// Rows that tell what is usual.
const FEW: usize = 33;

/// An input's usual value: the median over the first few rows, which are in random order.
fn usual(id: u8, rows: &Ordered, train: Range<usize>) -> f64 {
    let mut first = Vec::with_capacity(FEW);
    each_value(
        id,
        rows,
        train.start..train.end.min(train.start + FEW),
        |x| {
            first.push(x);
        },
    );
    first.sort_by(f64::total_cmp);
    first.get(first.len() / 2).copied().unwrap_or(f64::NAN)
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

/// Mean and standard deviation of the targets over some rows, each row weighted by
/// 1 / max(luminance, floor)²; for `exponential` outputs the mean as scale and no offset.
pub(crate) fn scale_outputs(
    rows: &Ordered,
    range: Range<usize>,
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
        // weight and target of each row that counts
        let each = |mut see: Box<dyn FnMut(f64, f64) + '_>| {
            rows.each(range.clone(), |chunk, rows| {
                for row in rows {
                    let (base, y) = (chunk.base(row, divide)[c], chunk.mean(row));
                    let weight = base / luminance(y).max(floor);
                    if weight > 0.0 {
                        see(weight, y[c] / base);
                    }
                }
            });
        };
        let (mut weight, mut sum) = (0.0, 0.0);
        each(Box::new(|w, y| {
            weight += w * w;
            sum += w * w * y;
        }));
        out.scale[c] = if exponential { 0.0 } else { 1.0 };
        if weight == 0.0 || !weight.is_finite() {
            continue;
        }
        let mean = sum / weight;
        let mut spread = 0.0;
        each(Box::new(|w, y| spread += (w * (y - mean)).powi(2)));
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

/// Noise over some rows.
pub(crate) fn noise(rows: &Ordered, range: Range<usize>, floor: f64) -> Noise {
    let mut covariance = [[0.0; CHANNELS]; CHANNELS];
    let count = range.len().max(1);
    rows.each(range, |chunk, rows| {
        for row in rows {
            let d = 0.5 / luminance(chunk.mean(row)).max(floor);
            let [a, b] = [0, 1].map(|half| chunk.halves[half][row].map(f64::from));
            let e: [f64; CHANNELS] = std::array::from_fn(|c| d * (a[c] - b[c]));
            for (i, row) in covariance.iter_mut().enumerate() {
                for (j, sum) in row.iter_mut().enumerate() {
                    *sum += e[i] * e[j];
                }
            }
        }
    });
    let trace: f64 = (0..CHANNELS).map(|c| covariance[c][c]).sum();
    let norm: f64 = covariance.iter().flatten().map(|c| c * c).sum();
    Noise {
        square: trace / (CHANNELS * count) as f64,
        overcount: if trace > 0.0 {
            CHANNELS as f64 * norm / (trace * trace)
        } else {
            1.0
        },
    }
}
