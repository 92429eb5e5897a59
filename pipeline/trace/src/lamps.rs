//! Emission of the scene's triangles.

use glam::Vec3;
use rrf_lights::EmittingTriangles;
use rrf_scene::{AreaLight, Scene};

/// The scene's triangles that emit, chosen by the power that `lights` give them, one for each of
/// the scene's area lights. `area_cdf` is the cumulative area of the scene's triangles.
pub(crate) fn emitting_triangles(
    scene: &Scene,
    area_cdf: &[f64],
    lights: &[AreaLight],
) -> EmittingTriangles {
    let mut before = 0.0;
    let columns = scene.triangle_light.iter().zip(area_cdf);
    EmittingTriangles::new(columns.map(|(&light, &upto)| {
        let area = upto - before;
        before = upto;
        let exitance = |light: &AreaLight| f64::from(light.radiance.element_sum()) * light.sides();
        (area, lights.get(light as usize).map_or(0.0, exitance))
    }))
}

/// Radiance that a triangle of the scene emits toward `v` [W/(sr m^2)], by `lights`, one for each
/// of the scene's area lights; `outward` is its geometric normal.
#[inline]
pub(crate) fn emission(
    scene: &Scene,
    lights: &[AreaLight],
    triangle: u32,
    outward: Vec3,
    v: Vec3,
) -> Vec3 {
    let id = scene.triangle_light[triangle as usize];
    let light = lights.get(id as usize);
    light.map_or(Vec3::ZERO, |light| light.emitted(outward, v))
}
