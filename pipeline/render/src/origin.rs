//! Text attributes of a frame that tell its origin.

use crate::options::RenderOptions;
use crate::view::{Lights, View};
use glam::Vec3;
use rrf_lights::OwnLight;
use rrf_scene::PointLight;

/// Attributes of a frame whose indirect light is that of a model of some method.
pub(crate) fn of_render(
    view: &View,
    lights: &Lights,
    options: &RenderOptions,
    method: &str,
) -> Vec<(String, String)> {
    let mut attributes = common(view, lights, options.aa.max(1));
    attributes.push(attribute("rrf.method", method));
    attributes.push(attribute("rrf.part", options.part.name()));
    attributes.push(attribute("rrf.negative", "Keep"));
    if options.gather > 0 {
        attributes.push(attribute("rrf.gather_rays", options.gather));
    }
    if options.fallback > 0 {
        attributes.push(attribute("rrf.fallback", "gathering"));
        attributes.push(attribute("rrf.fallback_rays_per_pixel", options.fallback));
    }
    attributes
}

/// Attributes of a path-traced frame of `aa` x `aa` rays and `spp` paths a pixel.
pub(crate) fn of_trace(
    view: &View,
    lights: &Lights,
    aa: u32,
    spp: u32,
    seed: u64,
) -> Vec<(String, String)> {
    let mut attributes = common(view, lights, aa);
    attributes.push(attribute("rrf.method", "path tracing"));
    attributes.push(attribute("rrf.paths_per_pixel", spp));
    attributes.push(attribute("rrf.seed", seed));
    attributes
}

fn common(view: &View, lights: &Lights, aa: u32) -> Vec<(String, String)> {
    let point = |l: &PointLight| format!("{} {}", triple(l.position), triple(l.intensity));
    let points: Vec<String> = lights.points.iter().map(point).collect();
    let source = |l: &OwnLight| format!("{}: {} {}", l.name, l.source.kind(), l.source.summary());
    let sources: Vec<String> = lights.sources.iter().map(source).collect();
    let unit = "radiance W/(sr m^2), linear Rec. 709, no exposure applied";
    let mut attributes = vec![
        attribute("rrf.version", env!("CARGO_PKG_VERSION")),
        attribute("rrf.unit", unit),
        attribute("rrf.eye", triple(view.eye)),
        attribute("rrf.forward", triple(view.forward)),
        attribute("rrf.up", triple(view.up)),
        attribute("rrf.right", triple(view.right)),
        attribute("rrf.fov_degrees", view.fov),
        attribute("rrf.rays_per_pixel", format!("{aa}x{aa}")),
        attribute("rrf.point_lights", points.join("; ")),
        attribute("rrf.area_lights", if lights.area { "on" } else { "off" }),
    ];
    if !sources.is_empty() {
        attributes.push(attribute("rrf.other_lights", ascii(&sources.join("; "))));
    }
    attributes
}

/// In ASCII: other readers take the bytes of attributes for UTF-8, our writer's are Latin-1.
fn attribute(name: &str, value: impl ToString) -> (String, String) {
    let value = value.to_string().replace('²', "^2").replace('°', " deg");
    let ascii = |c: char| if c.is_ascii() { c } else { '?' };
    (name.to_string(), value.chars().map(ascii).collect())
}

/// Text that every program reads: some refuse files whose attributes have other letters.
fn ascii(text: &str) -> String {
    let text = text.replace('²', "^2");
    text.chars()
        .map(|c| if c.is_ascii() { c } else { '?' })
        .collect()
}

fn triple(v: Vec3) -> String {
    format!("{},{},{}", v.x, v.y, v.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn attributes_are_ascii() {
        assert_eq!(ascii("Lämpchen: 1 W/m²"), "L?mpchen: 1 W/m^2");
    }
}
