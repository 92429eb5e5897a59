//! How far a picture is from a reference that is still noisy.

use crate::compare::{Measure, check_pair};
use crate::error::MetricsError;
use crate::estimate::{ErrorEstimate, SquareError};
use crate::frame::{FrameMetric, Pair, REL_MSE_EPSILON};
use crate::picture::Picture;
use crate::relative::{channel_mean, inverse_level, mean};
use crate::tone::Exposure;
use glam::DVec3;

/// A measure is known where its uncertainty is below this share of it.
const KNOWN: f64 = 1.0 / 3.0;

/// A measure against a noisy reference, and how well it is known.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct NoisyMeasure {
    /// The measure.
    #[serde(flatten)]
    pub measure: Measure,
    /// What the reference's noise may add to it or take from it.
    pub uncertainty: f64,
    /// Whether the uncertainty is below a third of the measure.
    pub is_known: bool,
}

/// Compares `test` with the mean of four independent pictures a, b, c, d of one reference.
///
/// The relative error and relMSE have the noise taken out: (p - a)(p - b) has the mean (p - m)², and the mean of c
/// and d, which is independent of it, serves for the divisor; so with all six pairs. What is left of the noise is
/// that of the divisor, which makes the square too large by 3 s² of itself, s² the relative variance of
/// (c + d) / 2. That and the standard error over pixels are the uncertainty. Colour differences and FLIP keep the
/// noise: half of what lies between two halves of the reference is what it makes alone.
pub fn compare_noisy(
    parts: &[Picture; 4],
    test: &Picture,
    exposure: Exposure,
) -> Result<Vec<NoisyMeasure>, MetricsError> {
    for part in parts {
        check_pair(part, test)?;
    }
    let [a, b, c, d] = parts;
    let halves = [mean_of(a, b), mean_of(c, d)];
    let whole = mean_of(&halves[0], &halves[1]);
    let pair = Pair::new(&whole, test, exposure);
    let between = Pair::new(&halves[0], &halves[1], exposure);
    let measure = |name: &str| {
        let metric = FrameMetric::named(name);
        metric.map(|metric| match metric.name {
            "relative_error" => {
                let scale = |m: DVec3| {
                    DVec3::splat(inverse_level(channel_mean(m.to_array()), pair.epsilon).powi(2))
                };
                found(metric, without_noise(parts, test, scale).relative())
            }
            "rel_mse" => {
                let scale = |m: DVec3| (m * m + REL_MSE_EPSILON).recip();
                let SquareError { mean, se } = without_noise(parts, test, scale);
                found(metric, (mean.max(0.0), se))
            }
            _ => found(metric, (metric.value(&pair), 0.5 * metric.value(&between))),
        })
    };
    let names = ["relative_error", "rel_mse", "delta_e_2000", "flip"];
    Ok(names.into_iter().filter_map(measure).collect())
}

fn mean_of(a: &Picture, b: &Picture) -> Picture {
    let pixels = a.pixels.iter().zip(&b.pixels);
    Picture {
        pixels: pixels.map(|(&a, &b)| 0.5 * (a + b)).collect(),
        ..*a
    }
}

/// A measure as found, with its uncertainty.
fn found(metric: &FrameMetric, (value, uncertainty): (f64, f64)) -> NoisyMeasure {
    NoisyMeasure {
        measure: Measure {
            name: metric.name,
            value,
            unit: metric.unit,
            definition: metric.definition,
        },
        uncertainty,
        is_known: uncertainty < KNOWN * value,
    }
}

/// The mean square of the difference from the reference times `scale` of the reference's level, with the noise
/// taken out, and its uncertainty.
fn without_noise(
    [a, b, c, d]: &[Picture; 4],
    test: &Picture,
    scale: impl Fn(DVec3) -> DVec3,
) -> SquareError {
    let rows = test.pixels.iter().enumerate().map(|(i, p)| {
        let p = p.as_dvec3();
        let [a, b, c, d] = [a, b, c, d].map(|part| part.pixels[i].as_dvec3());
        let product = |x: DVec3, y: DVec3, u: DVec3, v: DVec3| {
            ((p - x) * (p - y) * scale(0.5 * (u + v))).element_sum() / 3.0
        };
        let pairs = [
            (a, b, c, d),
            (c, d, a, b),
            (a, c, b, d),
            (b, d, a, c),
            (a, d, b, c),
            (b, c, a, d),
        ];
        let squares = pairs.map(|(x, y, u, v)| product(x, y, u, v));
        // relative variance of half of the parts
        let apart = 0.5 * ((a + b) - (c + d));
        let level = scale(0.25 * (a + b + c + d));
        let variance = 0.5 * (apart * apart * level).element_sum() / 3.0;
        (squares.iter().sum::<f64>() / 6.0, variance)
    });
    let (squares, variances): (Vec<f64>, Vec<f64>) = rows.unzip();
    let estimate = SquareError::from(ErrorEstimate::of(&squares));
    let added = 3.0 * mean(variances) * estimate.mean;
    SquareError {
        se: estimate.se.hypot(added),
        ..estimate
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use rrf_sampling::{Stage, Stream};

    /// A grey truth of 0.4 and an answer that is off by a tenth; four pictures of it with uniform noise of
    /// a standard deviation of `noise` times that.
    fn measures(noise: f32) -> Vec<NoisyMeasure> {
        let random = Stream::new(1, Stage::Test, 0);
        let picture = |value: &dyn Fn(u64) -> f32| Picture {
            width: 200,
            height: 200,
            pixels: (0..40_000).map(|i| Vec3::splat(value(i))).collect(),
        };
        let part = |h| picture(&|i| 0.4 + 0.4 * noise * 12f32.sqrt() * (random.f32(i, h) - 0.5));
        let test = picture(&|_| 0.44);
        compare_noisy(&[0, 1, 2, 3].map(part), &test, Exposure::default()).unwrap()
    }

    #[test]
    fn the_noise_is_taken_out_or_the_measure_is_not_known() {
        let clean = measures(0.0);
        assert!(
            clean.iter().all(|m| m.is_known && m.uncertainty < 1e-12),
            "{clean:?}"
        );
        for noise in [0.05, 0.1, 0.2, 0.4] {
            let found = measures(noise);
            for k in 0..2 {
                let (value, off) = (clean[k].measure.value, found[k].uncertainty);
                let told = &found[k];
                assert!((told.measure.value - value).abs() < 4.0 * off, "{told:?}");
                assert!(told.is_known, "{told:?}");
            }
        }
        // colours are compared as they are: noise as large as the difference hides it
        assert!(measures(0.01).iter().all(|m| m.is_known));
        assert!(measures(0.3)[2..].iter().all(|m| !m.is_known));
        assert!(!measures(1.0)[0].is_known);
    }

    #[test]
    fn pictures_that_do_not_match_are_refused() {
        let picture = |width| Picture {
            width,
            height: 1,
            pixels: vec![Vec3::ONE; width as usize],
        };
        let parts = [(); 4].map(|()| picture(2));
        assert!(compare_noisy(&parts, &picture(3), Exposure::default()).is_err());
        assert!(compare_noisy(&parts, &picture(2), Exposure::default()).is_ok());
    }
}
