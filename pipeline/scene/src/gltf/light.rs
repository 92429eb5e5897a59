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
//! A spot of P watts is written in the same way: its axis has I = P / (4 pi), whatever its cone,
//! so that the light that it sends is less than P. A sun of strength E, an irradiance in W/m², is
//! written as 683 E (lux), E and E.
//!
//! 683 lm/W is the efficacy of green light at 555 nm. It is the exporter's convention, not
//! that of white light, and a file from elsewhere in true candela needs its own factor.
//! Emission of materials is written by the exporter without any conversion, so it is read
//! as radiance whatever the units of the lights.
//!
//! A spot's course between its cones is what the extension recommends
//! ([`Falloff::Squared`]); Blender's own is another one, which a file does not have.

use super::document::{Document, place};
use super::nodes::Placed;
use super::output::Output;
use crate::{LightSource, LightUnits, LoadOptions, PointLight, SceneError};
use ::gltf::json::Root;
use ::gltf::json::extensions::scene::khr_lights_punctual::{Light, Type};
use ::gltf::json::validation::Checked;
use glam::{DVec3, Vec3};
use rrf_lights::{DistantLight, Falloff, SpotLight};
use std::f64::consts::PI;

/// Luminous efficacy that Blender's exporter uses [lm/W].
pub(super) const LUMENS_PER_WATT: f64 = 683.0;

/// Radiant intensity [W/sr] of a point or spot light whose file says `intensity`.
fn radiant_intensity(intensity: f64, units: LightUnits) -> f64 {
    match units {
        LightUnits::Spec => intensity / LUMENS_PER_WATT,
        LightUnits::Compat => intensity,
        LightUnits::Raw => intensity / (4.0 * PI),
    }
}

/// Irradiance [W/m²] of a directional light whose file says `intensity`.
fn irradiance(intensity: f64, units: LightUnits) -> f64 {
    match units {
        LightUnits::Spec => intensity / LUMENS_PER_WATT,
        LightUnits::Compat | LightUnits::Raw => intensity,
    }
}

/// Adds a node's light.
pub(super) fn add(
    document: &Document,
    placed: &Placed,
    options: &LoadOptions,
    output: &mut Output,
) -> Result<(), SceneError> {
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
    let source = source(placed, light, options.light_units);
    let source = source.map_err(|message| document.error(&place, message))?;
    let warnings = &mut output.warnings;
    if light.range.is_some() && source.position().is_some() {
        warnings.add(
            &place,
            "range left out: light falls off with the squared distance",
        );
    }
    let named = placed.node.name.as_ref().or(light.name.as_ref());
    let wanted = named.map_or_else(|| format!("light {index}"), String::clone);
    output.add_light(document, &place, &wanted, source)
}

/// The light in the world's frame; the error is a message.
fn source(placed: &Placed, light: &Light, units: LightUnits) -> Result<LightSource, String> {
    let color = DVec3::from_array(light.color.map(f64::from));
    let strength = f64::from(light.intensity);
    let intensity = (color * radiant_intensity(strength, units)).as_vec3();
    let position = placed.world.translation.as_vec3();
    Ok(match light.type_ {
        Checked::Valid(Type::Point) => PointLight {
            position,
            intensity,
        }
        .into(),
        Checked::Valid(Type::Directional) => DistantLight {
            toward: -forward(placed)?,
            irradiance: (color * irradiance(strength, units)).as_vec3(),
            diameter: 0.0,
        }
        .into(),
        Checked::Valid(Type::Spot) => {
            let spot = light.spot.as_ref();
            SpotLight {
                position,
                axis: forward(placed)?,
                intensity,
                inner: spot.map_or(0.0, |spot| spot.inner_cone_angle),
                outer: spot.map_or(std::f32::consts::FRAC_PI_4, |spot| spot.outer_cone_angle),
                falloff: Falloff::Squared,
            }
            .into()
        }
        Checked::Invalid => return Err("unknown type of light".into()),
    })
}

/// The way that a node looks, along its -z.
fn forward(placed: &Placed) -> Result<Vec3, String> {
    let forward = (-placed.world.matrix3.z_axis).try_normalize();
    let forward = forward.ok_or("its node's transform has no direction")?;
    Ok(forward.as_vec3())
}

/// In a file in candela the specification has emission in candela per square metre.
pub(super) fn note_mixed_units(root: &Root, options: &LoadOptions, output: &mut Output) {
    let scene = &output.scene;
    let has_both = !scene.area_lights.is_empty() && !scene.lights.is_empty();
    if has_both && options.light_units == LightUnits::Spec {
        let by = root.asset.generator.as_deref().unwrap_or("unknown");
        let message = format!(
            "lights are read in candela or lux (683 lm/W), emission of materials in W/(sr m^2), \
             as Blender writes them; this file was written by {by:?}"
        );
        output.warnings.add("light units", message);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sun_is_no_sphere() {
        for (written, units) in [
            (4.0 * 683.0, LightUnits::Spec),
            (4.0, LightUnits::Compat),
            (4.0, LightUnits::Raw),
        ] {
            assert_eq!(irradiance(written, units), 4.0);
        }
    }

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
