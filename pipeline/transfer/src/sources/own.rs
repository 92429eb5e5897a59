//! A scene's own lights as direct light, by name.

use super::lamp::Lamp;
use super::source::SourceLight;
use crate::lights::DirectLight;
use crate::tracing::Stream;
use rrf_scene::Scene;

/// The own light of that name, in the colours of the file; `None` where the scene has none.
pub fn named_light<'a>(
    scene: &'a Scene,
    name: &str,
    stream: Stream,
) -> Option<Box<dyn DirectLight + 'a>> {
    if let Some(light) = scene.lights.iter().find(|light| light.name == name) {
        return Some(Box::new(SourceLight::new(&light.source, stream)));
    }
    let names = &scene.area_light_names;
    let wanted = |id: u32| names.get(id as usize).is_some_and(|n| n == name);
    let lamp = Lamp::new(scene, wanted, stream);
    (!lamp.is_empty()).then(|| Box::new(lamp) as Box<dyn DirectLight>)
}
