//! Dielectric reflectance.

use super::document::Document;
use crate::SceneError;
use crate::warn::Warnings;
use ::gltf::json;
use glam::Vec3;

/// Our `specular` from KHR_materials_ior and KHR_materials_specular.
///
/// F0 = ((ior - 1) / (ior + 1))^2 * colour * factor, and F0 = 0.08 specular in Mitsuba's
/// `principled`, whose eta = 2 / (1 - sqrt(0.08 specular)) - 1 has that reflectance.
/// Beyond an index of 1.79 it exceeds 1: [`crate::validate`] clamps it with a warning.
pub(super) fn specular(
    document: &Document,
    place: &str,
    source: &json::Material,
    warnings: &mut Warnings,
) -> Result<f32, SceneError> {
    let Some(extensions) = &source.extensions else {
        return Ok(0.5);
    };
    let ior = extensions.ior.as_ref().map_or(1.5, |ior| ior.ior.0);
    // The extension gives 0 the meaning of an infinite index.
    if !(ior >= 1.0 && ior.is_finite()) && ior != 0.0 {
        let message = format!("index of refraction {ior} must be 0 or at least 1");
        return Err(document.error(place, message));
    }
    let ratio = if ior == 0.0 {
        1.0
    } else {
        (ior - 1.0) / (ior + 1.0)
    };
    let mut f0 = ratio * ratio;
    if let Some(specular) = &extensions.specular {
        let colour = Vec3::from_array(specular.specular_color_factor.0);
        let factor = specular.specular_factor.0;
        let is_usable = colour.is_finite() && colour.min_element() >= 0.0;
        if !is_usable || !(0.0..=1.0).contains(&factor) {
            let message = "specularFactor must be in [0, 1], specularColorFactor not negative";
            return Err(document.error(place, message));
        }
        if colour.min_element() != colour.max_element() {
            warnings.add(
                place,
                "coloured specular reflection is read as its luminance",
            );
        }
        if specular.specular_texture.is_some() || specular.specular_color_texture.is_some() {
            warnings.add(place, "specular textures left out: read as white");
        }
        if factor < 1.0 {
            let message = "specularFactor lowers the reflectance at normal incidence only, \
                           not at grazing angles";
            warnings.add(place, message);
        }
        // Rec. 709 luminance.
        let luminance = colour.dot(Vec3::new(0.2126, 0.7152, 0.0722));
        f0 = (f0 * luminance).min(1.0) * factor;
    }
    Ok(f0 / 0.08)
}
