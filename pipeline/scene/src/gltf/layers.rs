//! Glass, coats and opacity.

use super::document::Document;
use crate::warn::Warnings;
use crate::{INVALID, Material, SceneError};
use ::gltf::json;
use ::gltf::json::material::AlphaMode;
use ::gltf::json::validation::Checked;
use glam::Vec3;
use rrf_materials::{Layers, Opacity};
use serde_json::Value;

/// GGX roughness up to which glass is clear.
const CLEAR: f32 = 0.032;

/// Parameters of KHR_materials_transmission, _volume and _clearcoat.
struct Extras {
    transmission: f32,
    thickness: f32,
    absorption: Vec3,
    clearcoat: f32,
    clearcoat_roughness: f32,
}

/// An extension that the crate leaves as JSON.
fn extension<'a>(source: &'a json::Material, name: &str) -> Option<&'a Value> {
    source.extensions.as_ref()?.others.get(name)
}

impl Extras {
    fn read(
        document: &Document,
        place: &str,
        source: &json::Material,
        warnings: &mut Warnings,
    ) -> Result<Extras, SceneError> {
        let number = |extension: &str, name: &str, default: f32, most: f32| {
            let found = self::extension(source, extension).and_then(|e| e.get(name));
            let value = found.map_or(Some(default), |v| v.as_f64().map(|v| v as f32));
            let value = value.filter(|v| (0.0..=most).contains(v));
            let range = if most == 1.0 {
                "in [0, 1]"
            } else {
                "a number from 0 on"
            };
            value.ok_or_else(|| {
                document.error(place, format!("{extension}: {name} must be {range}"))
            })
        };
        let (glass, volume) = ("KHR_materials_transmission", "KHR_materials_volume");
        let coat = "KHR_materials_clearcoat";
        let extras = Extras {
            transmission: number(glass, "transmissionFactor", 0.0, 1.0)?,
            thickness: number(volume, "thicknessFactor", 0.0, f32::MAX)?,
            absorption: absorption(
                extension(source, volume).and_then(|v| v.get("attenuationColor")),
                number(volume, "attenuationDistance", f32::MAX, f32::MAX)?,
            )
            .ok_or_else(|| {
                let message = format!("{volume}: attenuationColor must be three numbers in [0, 1]");
                document.error(place, message)
            })?,
            clearcoat: number(coat, "clearcoatFactor", 0.0, 1.0)?,
            clearcoat_roughness: number(coat, "clearcoatRoughnessFactor", 0.0, 1.0)?,
        };
        for (extension, name) in [
            (glass, "transmissionTexture"),
            (volume, "thicknessTexture"),
            (coat, "clearcoatTexture"),
            (coat, "clearcoatRoughnessTexture"),
            (coat, "clearcoatNormalTexture"),
        ] {
            let there = self::extension(source, extension).and_then(|e| e.get(name));
            if there.is_some() {
                warnings.add(
                    place,
                    format!("{name} left out: its factor counts everywhere"),
                );
            }
        }
        Ok(extras)
    }
}

/// -ln(colour) / distance \[1/m\]: what remains of white light after the distance is the colour. Black
/// is taken for a thousandth.
fn absorption(colour: Option<&Value>, distance: f32) -> Option<Vec3> {
    let Some(colour) = colour else {
        return Some(Vec3::ZERO);
    };
    let numbers: Vec<f32> = colour
        .as_array()?
        .iter()
        .filter_map(Value::as_f64)
        .map(|v| v as f32)
        .collect();
    let [r, g, b] = numbers[..] else {
        return None;
    };
    let colour = Vec3::new(r, g, b);
    let inside = colour.min_element() >= 0.0 && colour.max_element() <= 1.0;
    (inside && distance > 0.0).then(|| -colour.max(Vec3::splat(1e-3)).ln() / distance)
}

/// What a metallic-roughness material becomes by its extensions for glass and coats. `ior` is its index of
/// refraction, where 0 means infinite.
pub(super) fn layered(
    document: &Document,
    place: &str,
    source: &json::Material,
    plain: Material,
    warnings: &mut Warnings,
) -> Result<Material, SceneError> {
    let extras = Extras::read(document, place, source, warnings)?;
    let ior = source.extensions.as_ref().and_then(|e| e.ior.as_ref());
    let ior = ior.map_or(1.5, |ior| ior.ior.0);
    let (transmits, coated) = (extras.transmission > 0.0, extras.clearcoat > 0.0);
    if !transmits && !coated {
        return Ok(plain);
    }
    if ior == 0.0 {
        warnings.add(
            place,
            "an index of refraction of 0 (infinite): glass and coat are left out",
        );
        return Ok(plain);
    }
    let solid = extras.thickness > 0.0;
    let (name, base) = (plain.name.clone(), plain.base_color);
    let whole = extras.transmission >= 0.999 && plain.metallic == 0.0 && !coated;
    let made = if transmits && !solid {
        if !whole {
            let message = "part of a thin surface's light goes straight through, as through a veil";
            warnings.add(place, message);
            return Ok(Material {
                opacity: Opacity {
                    value: 1.0 - extras.transmission * (1.0 - plain.metallic),
                    ..Opacity::OPAQUE
                },
                ..plain
            });
        }
        if plain.roughness > CLEAR {
            warnings.add(place, "a rough thin pane is read as a clear one");
        }
        Material::thin_dielectric(name, ior, base)
    } else if whole && plain.roughness <= CLEAR {
        Material::dielectric(name, ior, base, extras.absorption)
    } else if whole && plain.roughness_metallic_texture == INVALID {
        Material::rough_dielectric(name, ior, base, extras.absorption, plain.roughness)
    } else {
        if coated {
            let message = "the coat is Mitsuba's: GTR1 in place of GGX, a quarter as strong";
            warnings.add(place, message);
        }
        let alpha = extras.clearcoat_roughness * extras.clearcoat_roughness;
        let layers = Layers {
            clearcoat: extras.clearcoat,
            // alpha falls from 0.1 to 0.001
            clearcoat_gloss: ((0.1 - alpha) / 0.099).clamp(0.0, 1.0),
            transmission: extras.transmission,
            ior,
            absorption: extras.absorption,
        };
        Material::principled_extended(name, base, plain.roughness, plain.metallic, layers)
    };
    let mixed = match made.kind.has(rrf_materials::Storage::Metallic) {
        true => plain.roughness_metallic_texture,
        false => INVALID,
    };
    Ok(Material {
        base_texture: plain.base_texture,
        normal_texture: plain.normal_texture,
        roughness_metallic_texture: mixed,
        ..made
    })
}

/// Opacity by alphaMode; `texture` is that of the base colour's alpha.
pub(super) fn opacity(
    source: &json::Material,
    place: &str,
    texture: u32,
    warnings: &mut Warnings,
) -> Opacity {
    let cutoff = match source.alpha_mode {
        Checked::Valid(AlphaMode::Opaque) => return Opacity::OPAQUE,
        Checked::Valid(AlphaMode::Mask) => Some(source.alpha_cutoff.map_or(0.5, |c| c.0)),
        Checked::Valid(AlphaMode::Blend) => None,
        Checked::Invalid => {
            warnings.add(
                place,
                "alphaMode is neither OPAQUE, MASK nor BLEND: read as OPAQUE",
            );
            return Opacity::OPAQUE;
        }
    };
    Opacity {
        value: source.pbr_metallic_roughness.base_color_factor.0[3],
        texture,
        cutoff,
    }
}
