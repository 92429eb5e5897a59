//! The scene's lamps as a page has dimmed and moved them.

use crate::ask::Ask;
use crate::own::OwnLights;
use crate::show::Show;
use glam::Vec3;
use rrf_render::{AreaLights, Lights};
use rrf_scene::Scene;
use rrf_trace::Tracer;

/// The lamps of a scene under the dims that were last asked for: a change cuts them anew.
#[derive(Default)]
pub(crate) struct DimmedLamps {
    dims: Vec<Vec3>,
    lamps: Option<AreaLights>,
}

impl DimmedLamps {
    /// The lamps for a frame under `lights`.
    pub(crate) fn under<'l>(
        &'l mut self,
        own: &OwnLights<'l>,
        lights: &Lights,
    ) -> Option<&'l AreaLights> {
        if !lights.area {
            return None;
        }
        if lights.dims.iter().all(|&dim| dim == Vec3::ONE) {
            return Some(own.lamps);
        }
        if self.dims != lights.dims || self.lamps.is_none() {
            self.lamps = Some(own.lamps.dimmed(own.scene(), &lights.dims));
            self.dims.clone_from(&lights.dims);
        }
        self.lamps.as_ref()
    }
}

/// A scene for lamps that a page moves; its memory serves all moves.
#[derive(Default)]
pub(crate) struct MovedLamps(Option<Scene>);

impl MovedLamps {
    /// Hands `then` the show with its lamps where a question has them.
    ///
    /// # Errors
    /// If they cannot be there.
    pub(crate) fn show<T>(
        &mut self,
        show: &Show,
        ask: &Ask,
        then: impl FnOnce(&Show) -> T,
    ) -> Result<T, String> {
        let places = show.own.moved_lamps(ask);
        let Some((first, _)) = places.first() else {
            return Ok(then(show));
        };
        if !show.own.known {
            return Err(format!(
                "{first}: lamps of a run of nets are moved by `rrf render --move` alone"
            ));
        }
        let original = show.own.scene();
        let scene = match &mut self.0 {
            Some(scene) => {
                scene.put_back(original);
                scene
            }
            none => none.insert(original.clone()),
        };
        for (name, to) in places {
            scene.move_light(name, to).map_err(|e| e.to_string())?;
        }
        let tracer = Tracer::new(scene).map_err(|e| e.to_string())?;
        let tracer = tracer.until(show.halt);
        let own = OwnLights {
            tracer: &tracer,
            lamps: &AreaLights::without_proxies(scene),
            ..show.own
        };
        Ok(then(&Show {
            own,
            ..show.clone()
        }))
    }
}
