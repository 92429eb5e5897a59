//! Point lights and the emission of shapes.

use super::colour::place_of;
use super::fault::{Place, Read, fault};
use super::mesh::{Lights, Mesh};
use super::param::Type;
use super::params::Params;
use super::reader::Reader;
use super::state::Emission;
use crate::{AreaLight, PointLight};
use glam::DVec3;
use std::f64::consts::PI;

impl Reader {
    /// `LightSource`.
    pub fn light_source(&mut self, name: &str, at: Place, params: &Params) -> Read<()> {
        match name {
            "point" => self.point_light(params),
            "infinite" | "distant" | "spot" | "goniometric" | "projection" | "exinfinite" => {
                self.warn(
                    at,
                    format!(
                        "LightSource \"{name}\" is left out: the scene's default lights lack it; \
                         a bake, whose lights are points of its own, is the same"
                    ),
                );
                Ok(())
            }
            _ => fault(at, format!("unknown light \"{name}\"")),
        }
    }

    /// Radiant intensity `I * scale` [W/sr]; version 4's `power` over 4 pi instead of I's
    /// own brightness.
    fn point_light(&mut self, params: &Params) -> Read<()> {
        let mut intensity = self.emitted(params, "I")?.unwrap_or(DVec3::ONE);
        intensity *= self.light_scale(params)?;
        if let Some(power) = positive(params, "power")? {
            intensity *= power / (4.0 * PI);
        }
        let from = params.triple("from")?.unwrap_or(DVec3::ZERO);
        self.check_unused(params)?;
        let position = self.state.ctm.transform_point3(from).as_vec3();
        let intensity = intensity.as_vec3();
        if !position.is_finite() || !intensity.is_finite() {
            return fault(params.place, "the light's position or intensity overflows");
        }
        self.scene.point_lights.push(PointLight {
            position,
            intensity,
        });
        Ok(())
    }

    /// `scale`: a number, in version 3 a colour too.
    fn light_scale(&mut self, params: &Params) -> Read<DVec3> {
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

    /// `AreaLightSource`: the emission of the shapes that follow.
    pub fn area_light_source(&mut self, name: &str, at: Place, params: &Params) -> Read<()> {
        if name != "diffuse" && name != "area" {
            return fault(at, format!("unknown area light \"{name}\""));
        }
        params.ignore(&["nsamples", "samples"]);
        let mut radiance = self.emitted(params, "L")?.unwrap_or(DVec3::ONE);
        radiance *= self.light_scale(params)?;
        if let Some(file) = params.string("filename")? {
            let picture = self.linear_emission(file, place_of(params, "filename"))?;
            radiance *= picture;
        }
        let two_sided = params.bool("twosided")?.unwrap_or(false);
        let power = positive(params, "power")?;
        self.check_unused(params)?;
        if !radiance.as_vec3().is_finite() {
            return fault(params.place, "the light's radiance overflows");
        }
        self.state.emission = Some(self.emissions.len());
        self.emissions.push(Emission {
            radiance,
            two_sided,
            power,
            light: None,
        });
        Ok(())
    }

    /// A picture's mean stands for the picture.
    fn linear_emission(&mut self, file: &str, place: Place) -> Read<DVec3> {
        let id = self.linear_picture(file, place)?;
        self.warn(
            place,
            "a light's picture is approximated by its mean colour",
        );
        Ok(self.pictures.mean_of(id))
    }

    /// The lights of a shape under the emission in force.
    ///
    /// With `power`, version 4 gives each of pbrt's shapes that power, and each triangle of a
    /// mesh is such a shape, while a quadric is one: radiance = power / (pi area sides).
    pub fn lights_of(&mut self, mesh: &Mesh, quadric: bool, place: Place) -> Read<Lights> {
        let Some(emission) = self
            .state
            .emission
            .and_then(|i| self.emissions.get(i))
            .cloned()
        else {
            return Ok(Lights::None);
        };
        if self.recording.is_some() {
            self.warn(
                place,
                "an area light in an object with instances does not shine, as in pbrt",
            );
            return Ok(Lights::None);
        }
        let two_sided = emission.two_sided;
        let Some(power) = emission.power else {
            let light = emission
                .light
                .unwrap_or(self.scene.area_lights.len() as u32);
            if emission.light.is_none() {
                let radiance = emission.radiance.as_vec3();
                self.scene.area_lights.push(AreaLight {
                    radiance,
                    two_sided,
                });
            }
            if let Some(known) = self.state.emission.and_then(|i| self.emissions.get_mut(i)) {
                known.light = Some(light);
            }
            return Ok(Lights::One(light));
        };
        let sides = if two_sided { 2.0 } else { 1.0 };
        let areas: Vec<f64> = mesh.triangles.iter().map(|&t| mesh.area(t)).collect();
        let groups = if quadric {
            vec![areas.iter().sum()]
        } else {
            areas
        };
        let first = self.scene.area_lights.len() as u32;
        for area in groups {
            let scale = if area > 0.0 {
                power / (PI * area * sides)
            } else {
                0.0
            };
            let radiance = (emission.radiance * scale).as_vec3();
            if !radiance.is_finite() {
                return fault(
                    place,
                    "the radiance of this light overflows: its area is too small",
                );
            }
            self.scene.area_lights.push(AreaLight {
                radiance,
                two_sided,
            });
        }
        Ok(if quadric {
            Lights::One(first)
        } else {
            Lights::Each(first)
        })
    }
}

/// A number that counts only if above zero, as pbrt's `power`.
fn positive(params: &Params, name: &str) -> Read<Option<f64>> {
    Ok(params.float(name)?.filter(|&value| value > 0.0))
}
