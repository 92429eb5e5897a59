//! The emission of shapes.

use super::colour::place_of;
use super::fault::{Place, Read, fault};
use super::light::positive;
use super::mesh::{Lights, Mesh};
use super::params::Params;
use super::reader::Reader;
use super::spectrum::luminance;
use super::state::Emission;
use super::value::Mapping;
use crate::{AreaLight, INVALID};
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
        let two_sided = params.bool("twosided")?.unwrap_or(false);
        let mut power = positive(params, "power")?;
        let mut texture = INVALID;
        if let Some(file) = params.string("filename")? {
            let place = place_of(params, "filename");
            if let Some((id, factor)) = self.shining_picture(file, place)? {
                texture = id;
                radiance *= f64::from(factor);
                // the power is that of the picture's mean luminance, as in pbrt
                let level = luminance(radiance * self.pictures.mean_of(id));
                power = power.map(|power| power / if level > 0.0 { level } else { 1.0 });
            }
        }
        self.check_unused(params)?;
        if !radiance.as_vec3().is_finite() {
            return fault(params.place, "the light's radiance overflows");
        }
        self.state.emission = Some(self.emissions.len());
        self.emissions.push(Emission {
            radiance,
            texture,
            two_sided,
            power,
            light: None,
            name: None,
        });
        Ok(())
    }

    /// Whether the emission in force has a picture, which needs texture coordinates.
    pub fn shines_by_picture(&self) -> bool {
        let emission = self.state.emission.and_then(|i| self.emissions.get(i));
        emission.is_some_and(|emission| emission.texture != INVALID)
    }

    /// The emission in force for a material. A picture lies on the shape's own coordinates; where
    /// the material's textures have others, its mean stands for it.
    fn emission_on(&mut self, material: u32, place: Place) -> Option<Emission> {
        let mut emission = self.emissions.get(self.state.emission?)?.clone();
        let map = self.material_maps.get(material as usize);
        if emission.texture != INVALID && map.is_some_and(|map| *map != Mapping::IDENTITY) {
            let message = "a light's picture is approximated by its mean colour where the \
                           material's texture has another mapping";
            self.warn(place, message);
            emission.radiance *= self.pictures.mean_of(emission.texture);
            emission.texture = INVALID;
        }
        Some(emission)
    }

    /// The lights of a shape under the emission in force.
    ///
    /// With `power`, version 4 gives each of pbrt's shapes that power, and each triangle of a
    /// mesh is such a shape, while a quadric is one: radiance = power / (pi area sides).
    pub fn lights_of(&mut self, mesh: &Mesh, quadric: bool, place: Place) -> Read<Lights> {
        let Some(emission) = self.emission_on(mesh.material, place) else {
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
                self.add_emission(radiance, &emission, &name);
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
            self.add_emission(radiance, &emission, &name);
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

    fn add_emission(&mut self, radiance: Vec3, emission: &Emission, name: &str) {
        let light = AreaLight {
            radiance,
            two_sided: emission.two_sided,
        };
        let texture = emission.texture;
        self.scene.add_area_light(light, name.to_owned(), texture);
    }
}
