//! Reflectance of metals at normal incidence, from their complex index of refraction.

use super::spectrum::{Spectrum, reflectance};
use glam::DVec3;

/// One part, eta or k, of a complex index of refraction.
#[derive(Clone, Debug)]
pub(super) enum Index {
    /// At red, green and blue.
    Rgb(DVec3),
    /// Over wavelengths.
    Sampled(Spectrum),
}

impl Index {
    /// At red, green and blue; the wavelengths are where sRGB's primaries lie.
    fn rgb(&self) -> DVec3 {
        match self {
            Index::Rgb(rgb) => *rgb,
            Index::Sampled(spectrum) => {
                DVec3::new(spectrum.at(611.0), spectrum.at(549.0), spectrum.at(464.0))
            }
        }
    }
}

/// Linear sRGB reflectance at normal incidence in vacuum: ((eta-1)^2 + k^2) / ((eta+1)^2 + k^2).
pub(super) fn normal_reflectance(eta: &Index, k: &Index) -> DVec3 {
    if let (Index::Sampled(eta), Index::Sampled(k)) = (eta, k) {
        return reflectance(|lambda| fresnel(eta.at(lambda), k.at(lambda)));
    }
    let (eta, k) = (eta.rgb(), k.rgb());
    DVec3::new(
        fresnel(eta.x, k.x),
        fresnel(eta.y, k.y),
        fresnel(eta.z, k.z),
    )
}

/// Fresnel reflectance of a conductor at normal incidence; 0 for eta = 1, k = 0.
fn fresnel(eta: f64, k: f64) -> f64 {
    let below = (eta + 1.0).powi(2) + k * k;
    if below > 0.0 {
        ((eta - 1.0).powi(2) + k * k) / below
    } else {
        1.0
    }
}

/// Metals and two clear oxides that pbrt version 4 names: eta and k for red, green and blue.
///
/// Measured values (Palik, Handbook of Optical Constants of Solids) weighted by the colour
/// matching functions into sRGB, as is usual for renderers that work in RGB; the oxides at
/// the primaries' wavelengths.
const NAMED: [(&str, [f64; 3], [f64; 3]); 7] = [
    (
        "Ag",
        [0.155265, 0.116723, 0.138381],
        [4.828343, 3.122246, 2.146950],
    ),
    (
        "Al",
        [1.657460, 0.880369, 0.521229],
        [9.223869, 6.269523, 4.837001],
    ),
    (
        "Au",
        [0.143119, 0.374957, 1.442479],
        [3.983160, 2.385721, 1.603215],
    ),
    (
        "Cu",
        [0.200438, 0.924033, 1.102212],
        [3.912949, 2.452848, 2.142188],
    ),
    ("CuZn", [0.444, 0.527, 1.094], [3.695, 2.765, 1.829]),
    ("MgO", [1.734, 1.738, 1.746], [0.0, 0.0, 0.0]),
    ("TiO2", [2.591, 2.650, 2.800], [0.0, 0.0, 0.0]),
];

/// `metal-Cu-eta`, `metal-Cu-k` and the like.
pub(super) fn named(name: &str) -> Option<Index> {
    let (metal, part) = name.strip_prefix("metal-")?.rsplit_once('-')?;
    let (_, eta, k) = NAMED.iter().find(|(known, ..)| *known == metal)?;
    match part {
        "eta" => Some(Index::Rgb(DVec3::from_array(*eta))),
        "k" => Some(Index::Rgb(DVec3::from_array(*k))),
        _ => None,
    }
}

/// Copper, pbrt's default metal, as eta and k.
pub(super) fn copper() -> (Index, Index) {
    let (_, eta, k) = NAMED[3];
    (
        Index::Rgb(DVec3::from_array(eta)),
        Index::Rgb(DVec3::from_array(k)),
    )
}

/// Index of refraction at 587.6 nm of the glasses that pbrt version 4 names (Schott, Sumita).
pub(super) fn glass(name: &str) -> Option<f64> {
    Some(match name {
        "glass-BK7" => 1.5168,
        "glass-BAF10" => 1.6700,
        "glass-FK51A" => 1.4866,
        "glass-LASF9" => 1.8503,
        "glass-F5" | "glass-SF5" => 1.6727,
        "glass-F10" | "glass-SF10" => 1.7283,
        "glass-F11" | "glass-SF11" => 1.7847,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Characteristic specular reflectances, Akenine-Moeller et al., Real-Time Rendering,
    /// 4th edition, table 9.2 (gold's red lies outside sRGB there: 1.022).
    #[test]
    fn metals_reflect_as_published() {
        for (name, published) in [
            ("Ag", [0.972, 0.960, 0.915]),
            ("Al", [0.913, 0.922, 0.924]),
            ("Au", [1.0, 0.782, 0.344]),
            ("Cu", [0.955, 0.638, 0.538]),
        ] {
            let eta = named(&format!("metal-{name}-eta")).unwrap();
            let k = named(&format!("metal-{name}-k")).unwrap();
            let difference = normal_reflectance(&eta, &k) - DVec3::from_array(published);
            assert!(difference.abs().max_element() < 0.07, "{name} {difference}");
        }
    }

    /// Glass of index 1.5 reflects 4 %; a spectrum that is constant agrees with RGB.
    #[test]
    fn closed_form_and_both_forms_of_index() {
        let rgb = |v| Index::Rgb(DVec3::splat(v));
        let sampled = |v| Index::Sampled(Spectrum::from_pairs(&[400.0, v, 700.0, v]).unwrap());
        for (eta, k) in [
            (rgb(1.5), rgb(0.0)),
            (sampled(1.5), sampled(0.0)),
            (rgb(1.5), sampled(0.0)),
        ] {
            let f = normal_reflectance(&eta, &k);
            assert!((f - DVec3::splat(0.04)).abs().max_element() < 1e-12, "{f}");
        }
    }

    #[test]
    fn unknown_names_are_not_found() {
        assert!(named("metal-Xx-eta").is_none());
        assert!(named("metal-Cu-other").is_none());
        assert!(named("glass-BK7").is_none());
    }
}
