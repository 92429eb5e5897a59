//! Spectra to linear sRGB.
//!
//! Colour matching functions: Wyman, Sloan and Shirley, "Simple Analytic Approximations to
//! the CIE XYZ Color Matching Functions", JCGT 2(2), 2013 (multi-lobe fits, 1931 observer).
//! Illuminant D65: CIE table at 10 nm. Planck's law: wavelengths in nm, T in kelvin.

use glam::{DMat3, DVec3};

/// A spectrum as points, linear between them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Spectrum {
    /// Wavelengths [nm], strictly increasing.
    lambda: Vec<f64>,
    /// One value a wavelength.
    value: Vec<f64>,
}

impl Spectrum {
    /// From alternating wavelengths and values. `Err` says what is wrong.
    pub fn from_pairs(pairs: &[f64]) -> Result<Self, String> {
        if pairs.is_empty() || !pairs.len().is_multiple_of(2) {
            return Err(format!(
                "a spectrum needs pairs of wavelength and value, found {} numbers",
                pairs.len()
            ));
        }
        let lambda: Vec<f64> = pairs.iter().step_by(2).copied().collect();
        let value = pairs.iter().skip(1).step_by(2).copied().collect();
        match lambda
            .iter()
            .zip(lambda.iter().skip(1))
            .find(|(a, b)| a >= b)
        {
            Some((a, b)) => Err(format!("the wavelengths {a} and {b} nm do not increase")),
            None => Ok(Self { lambda, value }),
        }
    }

    /// From a text file of wavelengths and values, `#` starting a comment.
    pub fn from_text(text: &str) -> Result<Self, String> {
        let mut pairs = Vec::new();
        for line in text.lines() {
            let line = line.split('#').next().unwrap_or_default();
            for word in line.split_ascii_whitespace() {
                match word.parse::<f64>() {
                    Ok(value) if value.is_finite() => pairs.push(value),
                    _ => {
                        return Err(format!(
                            "`{}` is not a number",
                            super::token::shortened(word)
                        ));
                    }
                }
            }
        }
        Self::from_pairs(&pairs)
    }

    /// The value at a wavelength [nm]; beyond the ends the end values hold.
    pub fn at(&self, lambda: f64) -> f64 {
        let next = self.lambda.partition_point(|&l| l <= lambda);
        let point = |i: usize| Some((*self.lambda.get(i)?, *self.value.get(i)?));
        match (next.checked_sub(1).and_then(point), point(next)) {
            (Some((l0, v0)), Some((l1, v1))) => v0 + (v1 - v0) * (lambda - l0) / (l1 - l0),
            (Some((_, value)), None) | (None, Some((_, value))) => value,
            (None, None) => 0.0,
        }
    }
}

/// Piecewise Gaussian with one width on either side of its peak [nm].
fn lobe(lambda: f64, peak: f64, below: f64, above: f64) -> f64 {
    let t = (lambda - peak) / if lambda < peak { below } else { above };
    (-0.5 * t * t).exp()
}

/// The CIE 1931 colour matching functions at a wavelength [nm].
fn matching(lambda: f64) -> DVec3 {
    DVec3::new(
        1.056 * lobe(lambda, 599.8, 37.9, 31.0) + 0.362 * lobe(lambda, 442.0, 16.0, 26.7)
            - 0.065 * lobe(lambda, 501.1, 20.4, 26.2),
        0.821 * lobe(lambda, 568.8, 46.9, 40.5) + 0.286 * lobe(lambda, 530.9, 16.3, 31.1),
        1.217 * lobe(lambda, 437.0, 11.8, 36.0) + 0.681 * lobe(lambda, 459.0, 26.0, 13.8),
    )
}

/// CIE D65, 380 to 780 nm in steps of 10.
const D65: [f64; 41] = [
    49.9755, 54.6482, 82.7549, 91.486, 93.4318, 86.6823, 104.865, 117.008, 117.812, 114.861,
    115.923, 108.811, 109.354, 107.802, 104.79, 107.689, 104.405, 104.046, 100.0, 96.3342, 95.788,
    88.6856, 90.0062, 89.5991, 87.6987, 83.2886, 83.6992, 80.0268, 80.2146, 82.2778, 78.2842,
    69.7213, 71.6091, 74.349, 61.604, 69.8856, 75.087, 63.5927, 46.4182, 66.8054, 63.3828,
];

/// D65 at a wavelength [nm] from 380 to 780.
fn d65(lambda: f64) -> f64 {
    let t = ((lambda - 380.0) / 10.0).clamp(0.0, 40.0);
    let i = t.floor() as usize;
    let value = |i: usize| D65.get(i).copied().unwrap_or(63.3828);
    value(i) + (value(i + 1) - value(i)) * (t - t.floor())
}

/// The integral of a spectrum times the matching functions, 380 to 780 nm, 1 nm midpoints.
fn to_xyz(spectrum: impl Fn(f64) -> f64) -> DVec3 {
    (0..400).fold(DVec3::ZERO, |sum, i| {
        let lambda = 380.5 + f64::from(i);
        sum + spectrum(lambda) * matching(lambda)
    })
}

/// Y of linear sRGB (IEC 61966-2-1).
pub(super) fn luminance(rgb: DVec3) -> f64 {
    rgb.dot(DVec3::new(0.2126729, 0.7151522, 0.0721750))
}

/// XYZ to linear sRGB (IEC 61966-2-1; D65 white of Y = 1 becomes 1, 1, 1).
pub(super) fn xyz_to_rgb(xyz: DVec3) -> DVec3 {
    const M: DMat3 = DMat3::from_cols_array(&[
        3.2404542, -0.9692660, 0.0556434, -1.5371385, 1.8760108, -0.2040259, -0.4985314, 0.0415560,
        1.0572252,
    ]);
    M * xyz
}

/// A reflectance spectrum under D65 in linear sRGB; a constant c becomes exactly c, c, c.
pub(super) fn reflectance(spectrum: impl Fn(f64) -> f64) -> DVec3 {
    let white = xyz_to_rgb(to_xyz(d65));
    xyz_to_rgb(to_xyz(|lambda| spectrum(lambda) * d65(lambda))) / white
}

/// An emission spectrum in linear sRGB, the integral of y-bar taken as 1: a spectrum of
/// constant 1 has Y = 1 (pbrt version 3).
pub(super) fn emission(spectrum: impl Fn(f64) -> f64) -> DVec3 {
    xyz_to_rgb(to_xyz(spectrum) / to_xyz(|_| 1.0).y)
}

/// An emission spectrum's colour with Y = 1 (pbrt version 4, whose `scale` and `power` then
/// say how bright it is), or `None` where it has no light to see.
pub(super) fn emission_of_unit_luminance(spectrum: impl Fn(f64) -> f64) -> Option<DVec3> {
    let xyz = to_xyz(spectrum);
    (xyz.y > 0.0).then(|| xyz_to_rgb(xyz / xyz.y))
}

/// Black-body radiance at a wavelength [nm] relative to its peak (Planck; Wien's
/// displacement law for the peak), for a temperature [K] above zero.
pub(super) fn blackbody(temperature: f64) -> impl Fn(f64) -> f64 {
    // hc/k in nm K, and Wien's constant in the same unit.
    const C2: f64 = 1.438_776_877e7;
    const WIEN: f64 = 2.897_771_955e6;
    let planck = move |lambda: f64| 1.0 / (lambda.powi(5) * (C2 / (lambda * temperature)).exp_m1());
    let peak = planck(WIEN / temperature);
    move |lambda| planck(lambda) / peak
}

/// Linear sRGB of Y = 1 for a named illuminant of pbrt version 4.
pub(super) fn illuminant(name: &str) -> Option<DVec3> {
    // CIE 15: chromaticities of the standard illuminants.
    let (x, y) = match name {
        "stdillum-A" => (0.44757, 0.40745),
        "stdillum-D50" => (0.34567, 0.35850),
        "stdillum-D65" => return Some(DVec3::ONE),
        "illum-acesD60" => (0.32168, 0.33767),
        "stdillum-F1" => (0.31310, 0.33727),
        "stdillum-F2" => (0.37208, 0.37529),
        "stdillum-F7" => (0.31292, 0.32933),
        "stdillum-F11" => (0.38052, 0.37713),
        _ => return None,
    };
    Some(xyz_to_rgb(DVec3::new(x / y, 1.0, (1.0 - x - y) / y)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chromaticity(xyz: DVec3) -> (f64, f64) {
        let sum = xyz.x + xyz.y + xyz.z;
        (xyz.x / sum, xyz.y / sum)
    }

    /// CIE 15 gives the chromaticities; the fits of the matching functions are good to
    /// about 0.003 (Wyman et al. 2013, table 1: RMS errors of 1 % of the peak).
    #[test]
    fn chromaticities_of_standard_illuminants() {
        let planck = blackbody(2856.0);
        for (found, wanted) in [
            (chromaticity(to_xyz(d65)), (0.3127, 0.3290)),
            (chromaticity(to_xyz(planck)), (0.4476, 0.4074)),
            (chromaticity(to_xyz(|_| 1.0)), (1.0 / 3.0, 1.0 / 3.0)),
        ] {
            assert!((found.0 - wanted.0).abs() < 0.004, "{found:?} {wanted:?}");
            assert!((found.1 - wanted.1).abs() < 0.004, "{found:?} {wanted:?}");
        }
    }

    #[test]
    fn constant_reflectance_stays_grey() {
        let rgb = reflectance(|_| 0.25);
        assert!((rgb - DVec3::splat(0.25)).abs().max_element() < 1e-12);
    }

    #[test]
    fn emission_has_its_luminance() {
        // Y of linear sRGB, IEC 61966-2-1.
        let luminance = |rgb: DVec3| rgb.dot(DVec3::new(0.2126729, 0.7151522, 0.0721750));
        assert!((luminance(emission(|_| 3.0)) - 3.0).abs() < 1e-5);
        let warm = emission_of_unit_luminance(blackbody(3000.0)).unwrap();
        assert!((luminance(warm) - 1.0).abs() < 1e-5);
        assert!(warm.x > 1.5 && warm.z < 0.5, "{warm}");
        assert!(emission_of_unit_luminance(|_| 0.0).is_none());
    }

    #[test]
    fn points_are_joined_linearly() {
        let spectrum = Spectrum::from_text("# a comment\n400 1\n500 3 # more\n600 3").unwrap();
        for (lambda, value) in [
            (300.0, 1.0),
            (400.0, 1.0),
            (450.0, 2.0),
            (500.0, 3.0),
            (900.0, 3.0),
        ] {
            assert_eq!(spectrum.at(lambda), value);
        }
        assert!(Spectrum::from_pairs(&[400.0]).is_err());
        assert!(Spectrum::from_pairs(&[]).is_err());
        assert!(Spectrum::from_pairs(&[400.0, 1.0, 400.0, 2.0]).is_err());
        assert!(Spectrum::from_text("400 x").is_err());
    }
}
