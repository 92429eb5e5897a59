//! The emission of shapes.

use super::colour::place_of;
use super::fault::{Place, Read, fault};
use super::light::positive;
use super::mesh::{Lights, Mesh};
use super::params::Params;
use super::reader::Reader;
use super::spectrum::luminance;
use super::state::Emission;
use crate::AreaLight;
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

impl Reader {
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
        let mut power = positive(params, "power")?;
        if params.has("filename")
            && let Some(power) = &mut power
        {
            // the power is that of the picture's luminance, as in pbrt
            let level = luminance(radiance);
            *power /= if level > 0.0 { level } else { 1.0 };
        }
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
            name: None,
        });
        Ok(())
    }

    /// A picture's mean stands for the picture.
    fn linear_emission(&mut self, file: &str, place: Place) -> Read<DVec3> {
        let Some(id) = self.linear_picture(file, place)? else {
            return Ok(DVec3::ONE);
        };
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
        let name = emission.name.clone();
        let name = name.unwrap_or_else(|| self.next_light_name());
        let Some(power) = emission.power else {
            let light = emission
                .light
                .unwrap_or(self.scene.area_lights.len() as u32);
            if emission.light.is_none() {
                let radiance = emission.radiance.as_vec3();
                self.add_area_light(radiance, two_sided, &name);
            }
            if let Some(known) = self.emission_in_force() {
                (known.light, known.name) = (Some(light), Some(name));
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
            self.add_area_light(radiance, two_sided, &name);
        }
        if let Some(known) = self.emission_in_force() {
            known.name = Some(name);
        }
        Ok(if quadric {
            Lights::One(first)
        } else {
            Lights::Each(first)
        })
    }

    fn emission_in_force(&mut self) -> Option<&mut Emission> {
        let index = self.state.emission?;
        self.emissions.get_mut(index)
    }

    fn add_area_light(&mut self, radiance: Vec3, two_sided: bool, name: &str) {
        let light = AreaLight {
            radiance,
            two_sided,
        };
        self.scene.add_area_light(light, name.to_owned());
    }
}
