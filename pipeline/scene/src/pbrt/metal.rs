//! Complex indices of refraction of metals, and those of glasses.

use super::spectrum::Spectrum;
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
    pub(super) fn rgb(&self) -> DVec3 {
        match self {
            Index::Rgb(rgb) => *rgb,
            Index::Sampled(spectrum) => {
                DVec3::new(spectrum.at(611.0), spectrum.at(549.0), spectrum.at(464.0))
            }
        }
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
    use rrf_materials::{Bsdf, Material, Metal};

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
            let part = |part: &str| {
                let index = named(&format!("metal-{name}-{part}")).unwrap();
                index.rgb().as_vec3()
            };
            let metal = Metal {
                eta: part("eta"),
                k: part("k"),
            };
            let bsdf = Bsdf::of(&Material::conductor("", metal, glam::Vec3::ONE, 0.0));
            // straight back from a facet that faces the viewer: all of its light
            let z = glam::Vec3::Z;
            let found = bsdf.sample(z, z, [0.5, 0.0, 0.0]).weight.as_dvec3();
            let difference = found - DVec3::from_array(published);
            assert!(difference.abs().max_element() < 0.07, "{name} {difference}");
        }
    }

    #[test]
    fn unknown_names_are_not_found() {
        assert!(named("metal-Xx-eta").is_none());
        assert!(named("metal-Cu-other").is_none());
        assert!(named("glass-BK7").is_none());
    }
}
