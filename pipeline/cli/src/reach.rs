//! A warning about suns and skies that light nothing.

use glam::Vec3;
use rrf_sampling::{Stage, Stream};
use rrf_scene::{LightSource, OwnLight};
use rrf_trace::Tracer;

/// Says on standard error which of the lights from afar reach nothing that the eyes see.
pub fn warn(tracer: &Tracer, lights: &[OwnLight], eyes: &[Vec3]) {
    let far: Vec<&OwnLight> = lights.iter().filter(|l| is_far(&l.source)).collect();
    if far.is_empty() || eyes.is_empty() {
        return;
    }
    let sources: Vec<&LightSource> = far.iter().map(|light| &light.source).collect();
    // a cell of its own: no light of a frame has this number
    let stream = Stream::new(1, Stage::Direct, u32::MAX);
    let reached = tracer.reached(eyes, &sources, stream);
    for (light, _) in far.iter().zip(reached).filter(|(_, reached)| !reached) {
        eprintln!(
            "warning: light {:?} lights nothing: no path from the eye with up to three reflections \
             meets it. It stands below the horizon, or nothing lets it in",
            light.name
        );
    }
}

fn is_far(source: &LightSource) -> bool {
    source.position().is_none()
}
