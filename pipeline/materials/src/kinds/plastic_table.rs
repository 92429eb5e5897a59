//! Transmittance of a rough dielectric coat, tabulated.
//!
//! A viewer at cos(theta) sees the share T(cos(theta)) of what it sees refracted by the coat: the
//! integral of 1 - F, F Fresnel's reflectance, and of Smith's masking below over the microfacets that
//! it sees. The body sees a share of its own light reflected, R, the cosine-weighted mean of the
//! integral of F and masking from below. Both are tabulated over alpha and the index of refraction;
//! `tests::the_table_is_its_integrals` computes entries again, and with RRF_WRITE=1 writes the whole table.
//!
//! R stands there twice. Mitsuba takes the mean of 64 samples from cosine 0 to 1, both ends included,
//! which is some 1.5 % below the integral. Linear plastic, which is defined by Mitsuba, has that
//! one; nonlinear plastic, which is defined by what a coat does, has the integral.

/// Steps of cos(theta), of roughness = sqrt(alpha), and of the index of refraction.
const COSINES: usize = 64;
const ROUGHNESSES: usize = 16;
const INDICES: usize = 16;
/// Least and largest roughness and index of refraction of the table.
const ROUGHNESS: [f32; 2] = [0.031_622_78, 1.0];
const INDEX: [f32; 2] = [1.0, 2.5];
/// Transmittances \[index, roughness, cosine\], then internal reflectances \[index, roughness\], as
/// Mitsuba sums them and as integrals.
const NUMBERS: usize = INDICES * ROUGHNESSES * (COSINES + 2);

static TABLE: &[u8; 4 * NUMBERS] = include_bytes!("plastic_table.f32");

#[inline(always)]
fn number(at: usize) -> f32 {
    let bytes = TABLE.get(4 * at..4 * at + 4);
    bytes.map_or(0.0, |b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
}

/// Transmittance of the coat toward a viewer at `cosine`.
#[inline(always)]
pub(super) fn transmittance(cosine: f32, alpha: f32, eta: f32) -> f32 {
    let x = cosine.clamp(0.0, 1.0) * (COSINES - 1) as f32;
    let first = (x as usize).min(COSINES - 2);
    let t = x - first as f32;
    over_grid(alpha, eta, |index, roughness| {
        let at = (index * ROUGHNESSES + roughness) * COSINES + first;
        number(at) * (1.0 - t) + number(at + 1) * t
    })
}

/// Share of the body's diffuse light that the coat sends back to it, as Mitsuba sums it and as an
/// integral.
#[inline(always)]
pub(super) fn internal_reflectance(alpha: f32, eta: f32) -> [f32; 2] {
    [COSINES, COSINES + 1].map(|block| {
        over_grid(alpha, eta, |index, roughness| {
            number((INDICES * block + index) * ROUGHNESSES + roughness)
        })
    })
}

/// Cubic interpolation over both grids.
#[inline(always)]
fn over_grid(alpha: f32, eta: f32, at: impl Fn(usize, usize) -> f32) -> f32 {
    let (first_index, by_index) = cubic(eta, INDEX, INDICES);
    let (first, by_roughness) = cubic(alpha.sqrt(), ROUGHNESS, ROUGHNESSES);
    let mut sum = 0.0;
    for (i, a) in by_index.iter().enumerate() {
        for (j, b) in by_roughness.iter().enumerate() {
            sum += a * b * at(first_index + i, first + j);
        }
    }
    sum
}

/// The first of four steps around `x` and their weights: the cubic through all four.
#[inline(always)]
fn cubic(x: f32, [low, high]: [f32; 2], steps: usize) -> (usize, [f32; 4]) {
    let x = ((x - low) / (high - low)).clamp(0.0, 1.0) * (steps - 1) as f32;
    let first = (x as usize).saturating_sub(1).min(steps - 4);
    let t = x - first as f32;
    let (a, b, c, d) = (t, t - 1.0, t - 2.0, t - 3.0);
    let weights = [
        b * c * d / -6.0,
        a * c * d / 2.0,
        a * b * d / -2.0,
        a * b * c / 6.0,
    ];
    (first, weights)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fresnel::dielectric;
    use crate::ggx::{smith, visible_normal};
    use crate::refraction::{mirrored, refracted};
    use glam::Vec3;

    /// Mean over the microfacets that a viewer at `cosine` sees, at midpoints of their sampler.
    fn over_facets(cosine: f32, alpha: f32, steps: u32, of: impl Fn(Vec3, Vec3) -> f32) -> f64 {
        let v = Vec3::new((1.0 - cosine * cosine).max(0.0).sqrt(), 0.0, cosine);
        let mut sum = 0.0;
        for i in 0..steps {
            for j in 0..steps {
                let u = [i, j].map(|k| (k as f32 + 0.5) / steps as f32);
                sum += f64::from(of(v, visible_normal(v, alpha, u)));
            }
        }
        sum / f64::from(steps * steps)
    }

    fn fresnel(v: Vec3, h: Vec3, eta: f32) -> f32 {
        dielectric(v.dot(h).max(1e-9), eta)
    }

    fn reflected(cosine: f32, alpha: f32, eta: f32, steps: u32) -> f64 {
        over_facets(cosine, alpha, steps, |v, h| {
            let l = mirrored(v, h);
            let share = fresnel(v, h, eta) * smith(l.z, alpha);
            if l.z > 0.0 { share } else { 0.0 }
        })
    }

    fn transmitted(cosine: f32, alpha: f32, eta: f32, steps: u32) -> f64 {
        over_facets(cosine, alpha, steps, |v, h| {
            let l = refracted(v, h, eta);
            let share = (1.0 - fresnel(v, h, eta)) * smith(l.z, alpha);
            if l.z < 0.0 { share } else { 0.0 }
        })
    }

    fn step(k: usize, [low, high]: [f32; 2], steps: usize) -> f32 {
        low + (high - low) * k as f32 / (steps - 1) as f32
    }

    fn cosine(k: usize) -> f32 {
        step(k, [0.0, 1.0], COSINES).max(1e-6)
    }

    fn entry(index: usize, roughness: usize, k: usize, steps: u32) -> f32 {
        let alpha = step(roughness, ROUGHNESS, ROUGHNESSES).powi(2);
        transmitted(cosine(k), alpha, step(index, INDEX, INDICES), steps) as f32
    }

    fn internal(index: usize, roughness: usize, steps: u32) -> f32 {
        let alpha = step(roughness, ROUGHNESS, ROUGHNESSES).powi(2);
        let eta = 1.0 / step(index, INDEX, INDICES);
        let share = |k| f64::from(cosine(k)) * reflected(cosine(k), alpha, eta, steps);
        ((0..COSINES).map(share).sum::<f64>() * 2.0 / COSINES as f64) as f32
    }

    /// By midpoints of the cosine.
    fn integral(index: usize, roughness: usize, steps: u32) -> f32 {
        let alpha = step(roughness, ROUGHNESS, ROUGHNESSES).powi(2);
        let eta = 1.0 / step(index, INDEX, INDICES);
        let share = |k: u32| {
            let cosine = (k as f32 + 0.5) / steps as f32;
            2.0 * f64::from(cosine) * reflected(cosine, alpha, eta, steps)
        };
        ((0..steps).map(share).sum::<f64>() / f64::from(steps)) as f32
    }

    /// Entries again, with other numbers of points; RRF_WRITE=1 writes all of them.
    #[test]
    fn the_table_is_its_integrals() {
        if std::env::var_os("RRF_WRITE").is_some() {
            let mut bytes = Vec::new();
            for index in 0..INDICES {
                for roughness in 0..ROUGHNESSES {
                    for k in 0..COSINES {
                        let value = entry(index, roughness, k, 96);
                        bytes.extend_from_slice(&value.to_le_bytes());
                    }
                }
            }
            for index in 0..INDICES {
                for roughness in 0..ROUGHNESSES {
                    let value = internal(index, roughness, 160);
                    bytes.extend_from_slice(&value.to_le_bytes());
                }
            }
            for index in 0..INDICES {
                for roughness in 0..ROUGHNESSES {
                    let value = integral(index, roughness, 160);
                    bytes.extend_from_slice(&value.to_le_bytes());
                }
            }
            let path = concat!(env!("CARGO_MANIFEST_DIR"), "/src/kinds/plastic_table.f32");
            std::fs::write(path, bytes).unwrap();
            return;
        }
        for (index, roughness, k) in [(3, 2, 0), (5, 4, 20), (5, 15, 63), (8, 8, 1), (15, 0, 40)] {
            let at = (index * ROUGHNESSES + roughness) * COSINES + k;
            let error = number(at) - entry(index, roughness, k, 128);
            assert!(error.abs() < 1e-3, "{index} {roughness} {k}: {error}");
        }
        for (index, roughness) in [(5, 4), (9, 15)] {
            let at = INDICES * ROUGHNESSES * COSINES + index * ROUGHNESSES + roughness;
            let error = number(at) - internal(index, roughness, 128);
            assert!(error.abs() < 1e-3, "{index} {roughness}: {error}");
            let error = number(at + INDICES * ROUGHNESSES) - integral(index, roughness, 128);
            assert!(
                error.abs() < 1e-3,
                "{index} {roughness}: {error} of the integral"
            );
        }
    }
}
