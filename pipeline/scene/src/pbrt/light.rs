//! Lights that are no surface.
//!
//! Units and conventions are those of pbrt's `lights.cpp` (version 4) and `lights/*.cpp`
//! (version 3): a light's own frame is the current transform's, `I` and `L` times `scale`. Version
//! 4's `power` and `illuminance` say how bright the light is in all, in place of `I` and `L`,
//! which keep their colour. pbrt's lights have no names: here they are `light0`, `light1` …

use super::colour::place_of;
use super::fault::{Place, Read, fault};
use super::param::Type;
use super::params::Params;
use super::reader::Reader;
use super::state::Version;
use super::transform::orthogonal;
use crate::{LightSource, OwnLight, PointLight};
use glam::{DVec3, Vec3};
use rrf_lights::{DistantLight, Falloff, SpotLight};
use std::f64::consts::PI;

impl Reader {
    /// `LightSource`.
    pub fn light_source(&mut self, name: &str, at: Place, params: &Params) -> Read<()> {
        params.ignore(&["nsamples", "samples"]);
        match name {
            "point" => self.point_light(params),
            "distant" => self.distant_light(params),
            "spot" => self.spot_light(params),
            "goniometric" => self.goniometric_light(params),
            "infinite" | "exinfinite" => self.infinite_light(params),
            "projection" => {
                self.warn(
                    at,
                    "LightSource \"projection\" is left out: the light of the picture that it \
                     throws is missing",
                );
                Ok(())
            }
            _ => fault(at, format!("unknown light \"{name}\"")),
        }
    }

    /// Radiant intensity `I * scale` [W/sr]; version 4's `power` over 4 pi instead of I's
    /// own brightness.
    fn point_light(&mut self, params: &Params) -> Read<()> {
        let mut intensity = self.light_colour(params, "I")?;
        if let Some(power) = positive(params, "power")? {
            intensity *= power / (4.0 * PI);
        }
        let from = params.triple("from")?.unwrap_or(DVec3::ZERO);
        let light = PointLight {
            position: self.state.ctm.transform_point3(from).as_vec3(),
            intensity: intensity.as_vec3(),
        };
        self.add_light(params, light.into())
    }

    /// Irradiance `L * scale` [W/m²] on a plane that faces the light; version 4's `illuminance`
    /// instead of L's own brightness.
    fn distant_light(&mut self, params: &Params) -> Read<()> {
        let mut irradiance = self.light_colour(params, "L")?;
        irradiance *= positive(params, "illuminance")?.unwrap_or(1.0);
        let [from, to] = ends(params)?;
        let light = DistantLight {
            toward: self.direction(from - to, params.place)?,
            irradiance: irradiance.as_vec3(),
            diameter: 0.0,
        };
        self.add_light(params, light.into())
    }

    /// Radiant intensity `I * scale` [W/sr] on the axis; version 4's `power` in all.
    fn spot_light(&mut self, params: &Params) -> Read<()> {
        let mut intensity = self.light_colour(params, "I")?;
        let outer = params.float("coneangle")?.unwrap_or(30.0);
        let delta = params.float("conedeltaangle")?.unwrap_or(5.0);
        // pbrt takes the cosine, so that the sign does not matter
        let inner = (outer - delta).abs();
        if !(outer > 0.0 && outer <= 180.0 && inner <= outer) {
            let message = format!(
                "a cone of {outer} degrees whose light falls off from {inner} degrees on; angles \
                 from 0 to 180 are needed, the second not above the first"
            );
            return fault(params.place, message);
        }
        self.note_stretch(params.place, "its cone stays round");
        let [from, to] = ends(params)?;
        let mut light = SpotLight {
            position: self.state.ctm.transform_point3(from).as_vec3(),
            axis: self.direction(to - from, params.place)?,
            intensity: Vec3::ONE,
            inner: inner.to_radians() as f32,
            outer: outer.to_radians() as f32,
            falloff: match self.version() {
                Version::V3 => Falloff::Quartic,
                Version::V4 => Falloff::Smoothstep,
            },
        };
        if let Some(power) = positive(params, "power")? {
            intensity *= power / f64::from(light.solid_angle());
        }
        light.intensity = intensity.as_vec3();
        self.add_light(params, light.into())
    }

    /// Adds a light that can be computed with, once all of its parameters are read.
    pub(super) fn add_light(&mut self, params: &Params, source: LightSource) -> Read<()> {
        self.check_unused(params)?;
        if let Err(error) = source.check() {
            return fault(params.place, format!("{}: {error}", params.owner));
        }
        let name = match &source {
            LightSource::Environment(_) => self.light_names.sky(),
            _ => self.next_light_name(),
        };
        self.scene.lights.push(OwnLight { name, source });
        Ok(())
    }

    /// `light0`, `light1` … in file order.
    pub(super) fn next_light_name(&mut self) -> String {
        let name = format!("light{}", self.numbered_lights);
        self.numbered_lights += 1;
        self.light_names.unique(&name)
    }

    /// A light's colour times `scale`.
    pub(super) fn light_colour(&mut self, params: &Params, name: &str) -> Read<DVec3> {
        let colour = self.emitted(params, name)?.unwrap_or(DVec3::ONE);
        Ok(colour * self.light_scale(params)?)
    }

    /// `scale`: a number, in version 3 a colour too.
    pub(super) fn light_scale(&mut self, params: &Params) -> Read<DVec3> {
        let kinds = [
            Type::Float,
            Type::Rgb,
            Type::Xyz,
            Type::Spectrum,
            Type::Blackbody,
        ];
        let scale = match params.find("scale", &kinds)? {
            None => return Ok(DVec3::ONE),
            Some(param) if param.kind == Type::Float => {
                DVec3::splat(params.float("scale")?.unwrap_or(1.0))
            }
            Some(_) => self.emitted(params, "scale")?.unwrap_or(DVec3::ONE),
        };
        if scale.min_element() < 0.0 {
            return fault(
                place_of(params, "scale"),
                "\"scale\" of a light is negative",
            );
        }
        Ok(scale)
    }

    /// A unit world direction.
    fn direction(&self, local: DVec3, place: Place) -> Read<Vec3> {
        let world = self.state.ctm.transform_vector3(local);
        match world.try_normalize() {
            Some(direction) => Ok(direction.as_vec3()),
            None => fault(place, "\"from\" and \"to\" of this light are one point"),
        }
    }

    /// Warns where a light's own transform does more than turn, mirror and move.
    pub(super) fn note_stretch(&mut self, place: Place, kept: &str) {
        if !orthogonal(&self.state.ctm).is_some_and(|(_, similar)| similar) {
            self.warn(place, format!("the transform stretches this light: {kept}"));
        }
    }
}

/// `from` and `to`: the origin and +z unless given.
fn ends(params: &Params) -> Read<[DVec3; 2]> {
    Ok([
        params.triple("from")?.unwrap_or(DVec3::ZERO),
        params.triple("to")?.unwrap_or(DVec3::Z),
    ])
}

/// A number that counts only if above zero, as pbrt's `power`.
pub(super) fn positive(params: &Params, name: &str) -> Read<Option<f64>> {
    Ok(params.float(name)?.filter(|&value| value > 0.0))
}
