//! A scene's own lights, by name.

use crate::{INVALID, Scene};
use rrf_lights::{AreaLight, LightNames, LightSource, PointLight};
use std::collections::{HashMap, HashSet};

impl Scene {
    /// Names of the scene's own lights, each once: those of [`Scene::lights`] in their order, then
    /// those of area lights in the order of their first parts.
    pub fn own_light_names(&self) -> Vec<&str> {
        let mut seen = HashSet::new();
        let lights = self.lights.iter().map(|light| &light.name);
        lights
            .chain(&self.area_light_names)
            .map(String::as_str)
            .filter(|&name| seen.insert(name))
            .collect()
    }

    /// Whether anything shines in the scene as its file has it.
    pub fn has_own_lights(&self) -> bool {
        !self.lights.is_empty() || !self.area_lights.is_empty()
    }

    /// The isotropic points among the scene's own lights.
    pub fn points(&self) -> impl Iterator<Item = PointLight> + '_ {
        self.lights.iter().filter_map(|light| match light.source {
            LightSource::Point(point) => Some(point),
            _ => None,
        })
    }

    /// Adds an area light under its own light's name, with a texture or [`INVALID`]; returns its id.
    pub(crate) fn add_area_light(&mut self, light: AreaLight, name: String, texture: u32) -> u32 {
        if texture != INVALID {
            self.area_light_textures
                .resize(self.area_lights.len(), INVALID);
            self.area_light_textures.push(texture);
        }
        self.area_lights.push(light);
        self.area_light_names.push(name);
        self.area_lights.len() as u32 - 1
    }
}

/// Names of lights in formats that call a lamp by its material.
#[derive(Default)]
pub(crate) struct LampNames {
    names: LightNames,
    of_material: HashMap<u32, String>,
}

impl LampNames {
    /// The name of the lamps of a material, by its id.
    pub(crate) fn of_material(&mut self, id: u32, material: &str) -> String {
        let name = || self.names.unique(material);
        self.of_material.entry(id).or_insert_with(name).clone()
    }

    /// The name of a light that is no surface.
    pub(crate) fn of_light(&mut self, wanted: &str) -> String {
        self.names.unique(wanted)
    }
}
