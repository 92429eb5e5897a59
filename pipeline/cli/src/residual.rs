//! Lights that a transfer knows too little of.

use glam::Vec3;
use rrf_lights::LightSource;
use rrf_render::{Lights, MOST_RESIDUAL, position_text};
use rrf_scene::Scene;
use rrf_transfer::{LightBook, TransferError};

/// Says on standard error which lights the cells of a transfer leave too much of: nothing that they
/// light is trusted. `scene` has the lamps that shine.
pub fn warn(book: &LightBook, scene: &Scene, lights: &Lights) -> Result<(), TransferError> {
    let points = lights.points.iter().map(|&point| {
        let name = format!("the point light at {}", position_text(point.position));
        (name, LightSource::from(point))
    });
    let sources = lights.sources.iter();
    let sources = sources.map(|light| (format!("light {:?}", light.name), light.source.clone()));
    for (name, source) in points.chain(sources) {
        say(&name, book.under(&[source], None)?.residual);
    }
    if lights.area
        && scene
            .area_lights
            .iter()
            .any(|lamp| lamp.radiance != Vec3::ZERO)
    {
        say("a lamp", book.under(&[], Some(scene))?.residual);
    }
    Ok(())
}

fn say(name: &str, residual: f32) {
    if residual > MOST_RESIDUAL {
        eprintln!(
            "warning: {name}: the model's cells leave out {:.0} % of its light, so that nothing it lights \
             is trusted; `rrf trace` has all of it, and a bake with --light-box there knows more",
            100.0 * residual
        );
    }
}
