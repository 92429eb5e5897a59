//! A scene's own lights dimmed and moved, by name.

use crate::Scene;
use glam::{DVec3, Vec3};
use std::collections::HashMap;

/// Why an own light cannot be changed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LightChangeError {
    /// No own light has the name.
    #[error("the scene has no own light {name:?}; {known}")]
    Unknown {
        /// The name.
        name: String,
        /// The names that there are, in words.
        known: String,
    },
    /// The light shines from afar.
    #[error("the light {name:?} shines from afar: it has no position, so it cannot be moved")]
    NoPosition {
        /// Its name.
        name: String,
    },
}

impl Scene {
    /// Names of the scene's own lights in words, for messages.
    pub fn own_lights_in_words(&self) -> String {
        match self.own_light_names().as_slice() {
            [] => "it has no own lights".into(),
            names => format!("its own lights are {}", names.join(", ")),
        }
    }

    fn unknown_light(&self, name: &str) -> LightChangeError {
        LightChangeError::Unknown {
            name: name.to_string(),
            known: self.own_lights_in_words(),
        }
    }

    /// Multiplies an own light channel by channel.
    ///
    /// # Errors
    /// [`LightChangeError::Unknown`].
    pub fn dim_light(&mut self, name: &str, factor: Vec3) -> Result<(), LightChangeError> {
        let mut found = false;
        for light in self.lights.iter_mut().filter(|light| light.name == name) {
            light.source = light.source.dimmed(factor);
            found = true;
        }
        let areas = self.area_lights.iter_mut().zip(&self.area_light_names);
        for (light, _) in areas.filter(|(_, of)| *of == name) {
            light.radiance *= factor;
            found = true;
        }
        match found {
            true => Ok(()),
            false => Err(self.unknown_light(name)),
        }
    }

    /// Moves an own light: a point, spot or profile to `to`; a lamp so that the middle of the surface
    /// that shines comes there. What else belongs to the lamp stays.
    ///
    /// # Errors
    /// [`LightChangeError`].
    pub fn move_light(&mut self, name: &str, to: Vec3) -> Result<(), LightChangeError> {
        let no_position = || LightChangeError::NoPosition {
            name: name.to_string(),
        };
        if let Some(light) = self.lights.iter_mut().find(|light| light.name == name) {
            light.source = light.source.moved(to).ok_or_else(no_position)?;
            return Ok(());
        }
        let triangles = self.triangles_of_lamp(name);
        let middle = self.middle_of(&triangles);
        let middle = middle.ok_or_else(|| self.unknown_light(name))?;
        self.shift(&triangles, to - middle);
        Ok(())
    }

    /// Middle of a lamp's surface: where [`Scene::move_light`] says that it stands.
    pub fn middle_of_lamp(&self, name: &str) -> Option<Vec3> {
        self.middle_of(&self.triangles_of_lamp(name))
    }

    /// Takes surfaces back to where they are in `original`, of which this scene was a copy before its
    /// lights were moved.
    pub fn put_back(&mut self, original: &Scene) {
        self.positions.clone_from(&original.positions);
        self.normals.clone_from(&original.normals);
        self.uvs.clone_from(&original.uvs);
        self.triangles.clone_from(&original.triangles);
    }

    fn triangles_of_lamp(&self, name: &str) -> Vec<usize> {
        let names = |light: u32| self.area_light_names.get(light as usize);
        (0..self.triangles.len())
            .filter(|&t| names(self.triangle_light[t]).is_some_and(|of| of == name))
            .collect()
    }

    /// Middle of triangles' surface by area; `None` where they have none.
    fn middle_of(&self, triangles: &[usize]) -> Option<Vec3> {
        let (mut sum, mut total) = (DVec3::ZERO, 0.0);
        for &triangle in triangles {
            let area = self.triangle_area(triangle);
            let corners = self.triangles[triangle].map(|v| self.positions[v as usize].as_dvec3());
            sum += area / 3.0 * corners.into_iter().sum::<DVec3>();
            total += area;
        }
        (total > 0.0).then(|| (sum / total).as_vec3())
    }

    /// Moves triangles; what else uses their vertices keeps them where they are.
    fn shift(&mut self, triangles: &[usize], by: Vec3) {
        let mut moved = HashMap::new();
        for &triangle in triangles {
            for corner in 0..3 {
                let old = self.triangles[triangle][corner];
                let new = *moved.entry(old).or_insert_with(|| {
                    let old = old as usize;
                    self.positions.push(self.positions[old] + by);
                    self.normals.push(self.normals[old]);
                    self.uvs.push(self.uvs[old]);
                    self.positions.len() as u32 - 1
                });
                self.triangles[triangle][corner] = new;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LightSource, LoadOptions, OwnLight, load};
    use rrf_lights::{DistantLight, PointLight};
    use std::path::Path;

    /// The Cornell box, a point and a sun.
    fn scene() -> Scene {
        let path =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/cornell-box/scene.pbrt");
        let mut scene = load(&path, &LoadOptions::default()).unwrap();
        let point = PointLight {
            position: Vec3::Y,
            intensity: Vec3::ONE,
        };
        let sun = DistantLight::sun(Vec3::Y, Vec3::ONE);
        for (name, source) in [("bulb", LightSource::from(point)), ("far", sun.into())] {
            let name = name.to_string();
            scene.lights.push(OwnLight { name, source });
        }
        scene
    }

    #[test]
    fn lights_are_dimmed_by_name() {
        let (before, mut scene) = (scene(), scene());
        let lamp = before.area_light_names[0].clone();
        let factor = Vec3::new(0.5, 0.0, 2.0);
        scene.dim_light(&lamp, factor).unwrap();
        scene.dim_light("bulb", factor).unwrap();
        assert_eq!(
            scene.area_lights[0].radiance,
            before.area_lights[0].radiance * factor
        );
        assert_eq!(scene.points().next().unwrap().intensity, factor);
        let error = scene.dim_light("bulbs", factor).unwrap_err().to_string();
        assert!(
            error.contains("bulb, far") && error.contains(&lamp),
            "{error}"
        );
    }

    #[test]
    fn lights_are_moved_by_name() {
        let (before, mut scene) = (scene(), scene());
        let lamp = before.area_light_names[0].clone();
        let to = Vec3::new(0.1, 1.0, -0.2);
        scene.move_light(&lamp, to).unwrap();
        scene.move_light("bulb", to).unwrap();
        assert_eq!(scene.points().next().unwrap().position, to);
        let shining: Vec<usize> = (0..scene.triangles.len())
            .filter(|&t| scene.triangle_light[t] == 0)
            .collect();
        assert!(scene.middle_of(&shining).unwrap().distance(to) < 1e-5);
        for t in 0..scene.triangles.len() {
            let moved = shining.contains(&t);
            let corner = |s: &Scene| s.positions[s.triangles[t][1] as usize];
            assert_eq!(corner(&scene) != corner(&before), moved);
            let ratio = scene.triangle_area(t) / before.triangle_area(t);
            assert!((ratio - 1.0).abs() < 1e-5, "{ratio}");
        }
        assert!(scene.middle_of_lamp(&lamp).unwrap().distance(to) < 1e-5);
        let once = scene.positions.clone();
        scene.put_back(&before);
        assert_eq!(scene.middle_of_lamp(&lamp), before.middle_of_lamp(&lamp));
        scene.move_light(&lamp, to).unwrap();
        assert_eq!(scene.positions, once);
        let far = scene.move_light("far", to).unwrap_err();
        assert!(far.to_string().contains("no position"), "{far}");
    }
}
