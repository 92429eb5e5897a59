//! Frames as a screen's bytes: R, G, B and 255, row by row from the top left.

use crate::ask::ShownLayer;
use glam::Vec3;
use rayon::prelude::*;
use rrf_metrics::relative::{channel_mean, epsilon_of, inverse_level};
use rrf_metrics::tone::{Exposure, srgb8};
use rrf_metrics::{Picture, color::luminance};
use rrf_render::{Frame, png};
use std::sync::LazyLock;

/// Steps of [`FLOORS`]: 5 a grey level where the sRGB curve is steepest, so that a step has one border
/// between levels at the most.
const STEPS: usize = 1 << 14;
/// sRGB byte of the lower end of each step of linear values.
static FLOORS: LazyLock<Vec<u8>> = LazyLock::new(|| {
    (0..=STEPS)
        .map(|k| byte_of(k as f32 / STEPS as f32))
        .collect()
});
/// The least linear value of each sRGB byte.
static LEAST: LazyLock<Vec<f32>> = LazyLock::new(|| {
    let least = |byte: u8| {
        // positive numbers are ordered as their bits are
        let (mut below, mut reaching) = (0, 1f32.to_bits());
        while below < reaching {
            let middle = below.midpoint(reaching);
            match byte_of(f32::from_bits(middle)) < byte {
                true => below = middle + 1,
                false => reaching = middle,
            }
        }
        f32::from_bits(reaching)
    };
    (0..=u8::MAX).map(least).collect()
});

fn byte_of(linear: f32) -> u8 {
    srgb8(Vec3::splat(linear), Exposure::default())[0]
}

/// Pixels that a thread takes at once.
const RUN: usize = 4096;
/// The relative difference that [`difference`] shows in full colour.
pub const FULL_DIFFERENCE: f32 = 0.5;

/// A frame by its mode; `frame.full` holds the part asked for.
pub fn shown(frame: &Frame, mode: ShownLayer, exposure: Exposure) -> Vec<u8> {
    match mode {
        ShownLayer::Cells => {
            let cells = frame.cell.as_deref().unwrap_or_default();
            coded(cells, |&cell| png::cell_color(cell))
        }
        ShownLayer::Trust => trust(frame, exposure),
        _ => exposed(&frame.full, exposure),
    }
}

/// Linear radiance at an exposure: the bytes of [`srgb8`].
pub fn exposed(pixels: &[Vec3], exposure: Exposure) -> Vec<u8> {
    let (floors, least): (&[u8], &[f32]) = (&FLOORS, &LEAST);
    coded(pixels, |&pixel| {
        exposure.apply(pixel).to_array().map(|x| {
            let floor = floors[(x * STEPS as f32) as usize];
            let next = least.get(usize::from(floor) + 1);
            floor + u8::from(next.is_some_and(|&next| x >= next))
        })
    })
}

/// The picture in grey, where the nets were not trained in orange.
fn trust(frame: &Frame, exposure: Exposure) -> Vec<u8> {
    let trust = frame.trust.as_deref().unwrap_or_default();
    let pairs: Vec<(f32, f32)> = frame
        .full
        .iter()
        .zip(trust)
        .map(|(&p, &trust)| (luminance(p), trust))
        .collect();
    coded(&pairs, |&(y, trust)| {
        let [grey, ..] = srgb8(Vec3::splat(y), exposure);
        let doubt = 1.0 - trust.clamp(0.0, 1.0);
        let mix = |warning: f32| {
            let grey = f32::from(grey);
            (grey + doubt * (0.35 * grey + 0.65 * warning - grey)) as u8
        };
        [mix(255.0), mix(140.0), mix(0.0)]
    })
}

/// Differences of the channel means of `test` from those of `reference`, divided as in the relative
/// error: red where too bright, blue where too dark, full colour at [`FULL_DIFFERENCE`].
pub fn difference(reference: &Picture, test: &Picture) -> Vec<u8> {
    let rows = |picture: &'_ Picture| -> Vec<[f64; 3]> {
        let pixels = picture.pixels.iter();
        pixels.map(|p| p.as_dvec3().to_array()).collect()
    };
    let (reference, test) = (rows(reference), rows(test));
    let epsilon = epsilon_of(reference.iter().copied());
    let pairs = reference.into_iter().zip(test);
    let pairs = pairs.map(|(m, p)| {
        let [m, p] = [m, p].map(channel_mean);
        ((p - m) * inverse_level(m, epsilon)) as f32 / FULL_DIFFERENCE
    });
    coded(&pairs.collect::<Vec<f32>>(), |&signed| {
        let strength = signed.abs().min(1.0);
        let fade = |to: f32| (250.0 + strength * (to - 250.0)) as u8;
        if signed > 0.0 {
            [fade(200.0), fade(20.0), fade(30.0)]
        } else {
            [fade(20.0), fade(70.0), fade(210.0)]
        }
    })
}

fn coded<T: Sync>(values: &[T], color: impl Fn(&T) -> [u8; 3] + Sync) -> Vec<u8> {
    let mut bytes = vec![255; 4 * values.len()];
    let runs = bytes.par_chunks_mut(4 * RUN).zip(values.par_chunks(RUN));
    runs.for_each(|(bytes, values)| {
        for (rgba, value) in bytes.as_chunks_mut::<4>().0.iter_mut().zip(values) {
            let [r, g, b] = color(value);
            *rgba = [r, g, b, 255];
        }
    });
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The table against the formula, over ten stops and past both ends, and about every border.
    #[test]
    fn bytes_are_those_of_the_formula() {
        let exposure = Exposure { ev: 0.7 };
        let mut levels: Vec<f32> = (0..100_000).map(|i| 1e-3 * 1.0001f32.powi(i)).collect();
        levels.extend([0.0, -1.0, f32::NAN, f32::INFINITY, 1e30]);
        for x in LEAST.iter() {
            let about = (-3i32..=3).map(|k| x.to_bits().saturating_add_signed(k));
            levels.extend(about.map(|bits| f32::from_bits(bits) / exposure.ev.exp2()));
        }
        let pixels: Vec<Vec3> = levels.iter().map(|&x| Vec3::splat(x)).collect();
        let bytes = exposed(&pixels, exposure);
        for (rgba, &pixel) in bytes.chunks(4).zip(&pixels) {
            let [r, g, b] = srgb8(pixel, exposure);
            assert_eq!(rgba, [r, g, b, 255], "{pixel}");
        }
    }

    #[test]
    fn differences_have_a_sign() {
        let picture = |pixels: [f32; 3]| Picture {
            width: 3,
            height: 1,
            pixels: pixels.map(Vec3::splat).to_vec(),
        };
        let bytes = difference(&picture([1.0, 1.0, 1.0]), &picture([1.0, 2.0, 0.2]));
        assert_eq!(bytes[..4], [250, 250, 250, 255]);
        assert_eq!(bytes[4..8], [200, 20, 30, 255]);
        assert_eq!(bytes[8..], [20, 70, 210, 255]);
    }
}
