//! The scale of a cell's targets, and their noise.

use crate::net::tile::CHANNELS;
use crate::rows::order::OrderedRows;
use crate::rows::units::OutputScale;
use rrf_metrics::channel_mean;
use std::ops::Range;

/// Mean and standard deviation of the targets over some rows, each row weighted by
/// 1 / max(channel mean, floor)²; for `exponential` outputs the mean as scale and no offset.
pub(crate) fn outputs(
    rows: &OrderedRows,
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
                    let weight = base / channel_mean(y).max(floor);
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

/// The noise of the targets, from the difference of two independent halves: half of it has
/// the variance of their mean.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Noise {
    /// Mean squared noise relative to max(channel mean, floor), over rows and channels.
    pub square: f64,
    /// How many times the channels count the same noise: 1 where independent, 3 where equal.
    /// With C the covariance of the channels' noise, 3 ‖C‖² / (tr C)².
    pub overcount: f64,
}

/// Noise over some rows.
pub(crate) fn noise(rows: &OrderedRows, range: Range<usize>, floor: f64) -> Noise {
    let mut covariance = [[0.0; CHANNELS]; CHANNELS];
    let count = range.len().max(1);
    rows.each(range, |chunk, rows| {
        for row in rows {
            let d = 0.5 / channel_mean(chunk.mean(row)).max(floor);
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
