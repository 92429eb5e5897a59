//! The scene as read so far.

use super::document::Document;
use crate::own_lights::LampNames;
use crate::warn::Warnings;
use crate::{LightSource, OwnLight, Scene, SceneError};

/// A scene on its way.
#[derive(Default)]
pub(super) struct Output {
    pub(super) scene: Scene,
    pub(super) warnings: Warnings,
    pub(super) light_names: LampNames,
}

impl Output {
    /// Adds a light that can be computed with.
    pub(super) fn add_light(
        &mut self,
        document: &Document,
        place: &str,
        wanted: &str,
        source: LightSource,
    ) -> Result<(), SceneError> {
        if let Err(error) = source.check() {
            return Err(document.error(place, error.to_string()));
        }
        let name = self.light_names.of_light(wanted);
        self.scene.lights.push(OwnLight { name, source });
        Ok(())
    }
}
