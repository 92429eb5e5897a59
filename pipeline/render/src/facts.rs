//! What a frame says of its origin: text attributes of the OpenEXR file.

use crate::render::RenderOptions;
use crate::view::{Lights, View};
use glam::Vec3;

/// Attributes of a frame made by the nets.
pub fn of_render(view: &View, lights: &Lights, options: &RenderOptions) -> Vec<(String, String)> {
    let mut facts = common(view, lights, options.aa.max(1));
    facts.push(fact("rrf.method", "radiance regression"));
    facts.push(fact("rrf.part", format!("{:?}", options.part)));
    facts.push(fact("rrf.negative", format!("{:?}", options.negative)));
    facts
}

/// Attributes of a path-traced frame.
pub fn of_trace(
    view: &View,
    lights: &Lights,
    aa: u32,
    spp: u32,
    seed: u64,
) -> Vec<(String, String)> {
    let mut facts = common(view, lights, aa);
    facts.push(fact("rrf.method", "path tracing"));
    facts.push(fact("rrf.paths_per_pixel", spp.to_string()));
    facts.push(fact("rrf.seed", seed.to_string()));
    facts
}

fn common(view: &View, lights: &Lights, aa: u32) -> Vec<(String, String)> {
    let point = |light: &rrf_scene::PointLight| {
        format!("{} {}", triple(light.position), triple(light.intensity))
    };
    let points: Vec<String> = lights.points.iter().map(point).collect();
    vec![
        fact("rrf.version", env!("CARGO_PKG_VERSION")),
        fact(
            "rrf.unit",
            "radiance W/(sr m^2), linear Rec. 709, no exposure applied",
        ),
        fact("rrf.eye", triple(view.eye)),
        fact("rrf.forward", triple(view.forward)),
        fact("rrf.up", triple(view.up)),
        fact("rrf.right", triple(view.right)),
        fact("rrf.fov_degrees", view.fov.to_string()),
        fact("rrf.rays_per_pixel", format!("{aa}x{aa}")),
        fact("rrf.point_lights", points.join("; ")),
        fact("rrf.area_lights", if lights.area { "on" } else { "off" }),
    ]
}

fn fact(name: &str, value: impl Into<String>) -> (String, String) {
    (name.to_string(), value.into())
}

fn triple(v: Vec3) -> String {
    format!("{},{},{}", v.x, v.y, v.z)
}
