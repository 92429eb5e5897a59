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

    /// The scene's own light of a name.
    ///
    /// # Errors
    /// [`UnknownLight`], which lists the names that there are.
    pub fn own_light(&self, name: &str) -> Result<OwnLightParts<'_>, UnknownLight> {
        let source = self.lights.iter().find(|light| light.name == name);
        let named = (0..).zip(&self.area_light_names);
        let area_lights = named.filter(|(_, n)| *n == name).map(|(id, _)| id);
        let parts = OwnLightParts {
            source: source.map(|light| &light.source),
            area_lights: area_lights.collect(),
        };
        match parts.source.is_some() || !parts.area_lights.is_empty() {
            true => Ok(parts),
            false => Err(UnknownLight {
                name: name.into(),
                known: self.own_light_names().into_iter().map(Into::into).collect(),
            }),
        }
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

/// What one own light of a scene consists of: a light that is no surface, or area lights.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnLightParts<'a> {
    /// The light that is no surface.
    pub source: Option<&'a LightSource>,
    /// Ids of the area lights.
    pub area_lights: Vec<u32>,
}

/// A name that no own light of the scene has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "no light is called {name:?}; the scene's own lights are {}",
    listed(known)
)]
pub struct UnknownLight {
    /// The name asked for.
    pub name: String,
    /// The names that there are.
    pub known: Vec<String>,
}

/// Most names that a message lists.
const MOST_LISTED: usize = 20;

fn listed(names: &[String]) -> String {
    let mut text = names
        .iter()
        .take(MOST_LISTED)
        .cloned()
        .collect::<Vec<_>>()
        .join(", ");
    match names.len().checked_sub(MOST_LISTED) {
        None if names.is_empty() => text += "none",
        None | Some(0) => {}
        Some(more) => text += &format!(" and {more} more"),
    }
    text
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::OwnLight;
    use glam::Vec3;

    #[test]
    fn own_lights_are_found_by_their_names() {
        let mut scene = Scene::default();
        let unknown = scene.own_light("lamp").unwrap_err().to_string();
        assert!(
            unknown.contains("\"lamp\"") && unknown.contains("none"),
            "{unknown}"
        );
        let light = AreaLight {
            radiance: Vec3::ONE,
            two_sided: false,
        };
        for name in ["lamp", "shade", "lamp"] {
            scene.add_area_light(light, name.into(), INVALID);
        }
        let source = LightSource::Point(PointLight {
            position: Vec3::ZERO,
            intensity: Vec3::ONE,
        });
        let name = "bulb".into();
        scene.lights.push(OwnLight { name, source });
        assert_eq!(scene.own_light("lamp").unwrap().area_lights, [0, 2]);
        let bulb = scene.own_light("bulb").unwrap();
        assert_eq!(bulb.source, Some(&scene.lights[0].source));
        assert!(bulb.area_lights.is_empty());
        let unknown = scene.own_light("sky").unwrap_err().to_string();
        assert!(unknown.ends_with("are bulb, lamp, shade"), "{unknown}");
    }
}
