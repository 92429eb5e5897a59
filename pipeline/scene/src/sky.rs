//! A sky for a scene that has none.

use crate::options::{SkyOption, SkySource};
use crate::texture::linear_picture;
use crate::{OwnLight, Scene, SceneError};
use glam::{Mat3, Vec3};
use rrf_lights::{Environment, EnvironmentMap, LightNames, Mapping};
use std::path::Path;

impl Scene {
    /// Puts another sky in the place of the scene's, or gives it one.
    ///
    /// # Errors
    /// [`SceneError`] where its picture cannot be read.
    pub fn replace_sky(&mut self, option: &SkyOption) -> Result<(), SceneError> {
        self.lights.retain(|light| !light.source.is_sky());
        add_sky(self, option)
    }
}

/// Adds the sky that a user asks for, lat-long with +y up.
pub(crate) fn add_sky(scene: &mut Scene, option: &SkyOption) -> Result<(), SceneError> {
    if let Some(light) = scene.lights.iter().find(|light| light.source.is_sky()) {
        return refuse(
            &scene.source,
            format!(
                "the file has an environment of its own, {:?}; leave --sky out",
                light.name
            ),
        );
    }
    let sky = match &option.source {
        SkySource::Constant(radiance) => Environment::constant(Vec3::from(*radiance)),
        SkySource::Picture(path) => of_picture(path, option.rotate)?,
    };
    let mut names = LightNames::default();
    let name = names.sky();
    scene.lights.push(OwnLight {
        name,
        source: sky.into(),
    });
    Ok(())
}

fn of_picture(path: &Path, degrees: f32) -> Result<Environment, SceneError> {
    if let Err(source) = path.metadata() {
        let path = path.to_path_buf();
        return Err(SceneError::Io { path, source });
    }
    let picture = linear_picture(path).or_else(|message| refuse(path, message))?;
    // the picture turned from -z towards +x: a direction is looked up the same angle before
    let to_map = Mat3::from_rotation_y(degrees.to_radians());
    let size = (picture.width, picture.height);
    let map = EnvironmentMap::new(size, picture.texels, Mapping::LatLong, to_map);
    let map = map.or_else(|error| refuse(path, error.to_string()))?;
    Ok(Environment::of_map(map))
}

fn refuse<T>(path: &Path, message: String) -> Result<T, SceneError> {
    Err(SceneError::Content {
        path: path.to_path_buf(),
        place: "--sky".into(),
        message,
    })
}
