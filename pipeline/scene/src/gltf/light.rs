//! KHR_lights_punctual.
//!
//! What Blender's exporter writes for a point light of P watts is P / (4 pi) times 683 lm/W
//! ("standard", [`LightUnits::Spec`]), P / (4 pi) ("unitless", [`LightUnits::Compat`]) or P
//! itself ("raw", [`LightUnits::Raw`]) (io_scene_gltf2, `exp/lights.py`, with
//! PBR_WATTS_TO_LUMENS = 683). All three come back to the same radiant intensity
//! I = P / (4 pi) in each channel, so that P is the radiant power over the whole sphere.
//! That is also what Blender renders: Cycles weighs a point light's strength with
//! 1 / (4 pi) over the squared distance (`kernel/light/point.h`), without a further 1 / pi.
//!
//! 683 lm/W is the efficacy of green light at 555 nm. It is the exporter's convention, not
//! that of white light, and a file from elsewhere in true candela needs its own factor.
//! Emission of materials is written by the exporter without any conversion, so it is read
//! as radiance whatever the units of the lights.

use super::document::{Document, place};
use super::nodes::Placed;
use super::output::Output;
use crate::{LightUnits, LoadOptions, PointLight, SceneError};
use ::gltf::json::Root;
use ::gltf::json::extensions::scene::khr_lights_punctual::Type;
use ::gltf::json::validation::Checked;
use glam::DVec3;
use std::f64::consts::PI;

/// Luminous efficacy that Blender's exporter uses [lm/W].
const LUMENS_PER_WATT: f64 = 683.0;

/// Radiant intensity [W/sr] of a point light whose file says `intensity`.
fn radiant_intensity(intensity: f64, units: LightUnits) -> f64 {
    match units {
        LightUnits::Spec => intensity / LUMENS_PER_WATT,
        LightUnits::Compat => intensity,
        LightUnits::Raw => intensity / (4.0 * PI),
    }
}

/// Adds a node's point light.
pub(super) fn add(
    document: &Document,
    placed: &Placed,
    options: &LoadOptions,
    output: &mut Output,
) -> Result<(), SceneError> {
    let warnings = &mut output.warnings;
    let index = placed
        .node
        .extensions
        .as_ref()
        .and_then(|extensions| extensions.khr_lights_punctual.as_ref())
        .map(|reference| reference.light);
    let Some((index, light)) =
        index.and_then(|index| Some((index.value(), document.root.get(index)?)))
    else {
        return Ok(());
    };
    let place = place("light", index, light.name.as_deref());
    match light.type_ {
        Checked::Valid(Type::Point) => {}
        Checked::Valid(Type::Spot) => {
            warnings.add(place, "spot light left out: only point lights are read");
            return Ok(());
        }
        Checked::Valid(Type::Directional) | Checked::Invalid => {
            warnings.add(
                place,
                "directional light left out: only point lights are read",
            );
            return Ok(());
        }
    }
    let color = DVec3::from_array(light.color.map(f64::from));
    let strength = radiant_intensity(f64::from(light.intensity), options.light_units);
    let intensity = (color * strength).as_vec3();
    let position = placed.world.translation.as_vec3();
    if !intensity.is_finite() || intensity.min_element() < 0.0 || !position.is_finite() {
        let message = format!("{intensity} W/sr at {position} must be finite and not negative");
        return Err(document.error(place, message));
    }
    if light.range.is_some() {
        warnings.add(
            place,
            "range left out: light falls off with the squared distance",
        );
    }
    output.scene.point_lights.push(PointLight {
        position,
        intensity,
    });
    Ok(())
}

/// In a file in candela the specification has emission in candela per square metre.
pub(super) fn note_mixed_units(root: &Root, options: &LoadOptions, output: &mut Output) {
    let scene = &output.scene;
    let has_both = !scene.area_lights.is_empty() && !scene.point_lights.is_empty();
    if has_both && options.light_units == LightUnits::Spec {
        let by = root.asset.generator.as_deref().unwrap_or("unknown");
        let message = format!(
            "point lights are read in candela (683 lm/W), emission of materials in W/(sr m^2), \
             as Blender writes them; this file was written by {by:?}"
        );
        output.warnings.add("light units", message);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blenders_three_modes_mean_the_same() {
        // A 100 W point light, as the exporter wrote it.
        let want = 100.0 / (4.0 * PI);
        for (written, units) in [
            (5_435.141_306_588_225, LightUnits::Spec),
            (7.957_747_154_594_767, LightUnits::Compat),
            (100.0, LightUnits::Raw),
        ] {
            let got = radiant_intensity(written, units);
            assert!((got / want - 1.0).abs() < 1e-14, "{units:?}: {got}");
        }
    }
}
