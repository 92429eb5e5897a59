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
    let columns = scene.triangle_light.iter().zip(area_cdf).enumerate();
    EmittingTriangles::new(columns.map(|(triangle, (&id, &upto))| {
        let area = upto - before;
        before = upto;
        let exitance = |light: &AreaLight| {
            let share = chosen_share(scene, triangle, id);
            f64::from((light.radiance * share).element_sum()) * light.sides()
        };
        (area, lights.get(id as usize).map_or(0.0, exitance))
    }))
}

/// Share of a triangle's radiance that its choice is made by. Every triangle of a picture that is
/// not black has some, since only triangles that can be chosen are believed to shine.
fn chosen_share(scene: &Scene, triangle: usize, light: u32) -> Vec3 {
    match scene.emission_texture(light) {
        Some(picture) => {
            let whole = picture.mean().as_vec3();
            scene.mean_share(triangle as u32) + LEAST_SHARE * whole
        }
        None => Vec3::ONE,
    }
}

/// Share of a whole picture's mean that is added to that over a triangle.
const LEAST_SHARE: f32 = 1.0 / 16.0;

/// Radiance that a triangle of the scene emits toward `v` [W/(sr m^2)], by `lights`, one for each
/// of the scene's area lights, at a point by its barycentrics; `outward` is the triangle's geometric
/// normal.
#[inline]
pub(crate) fn emission(
    scene: &Scene,
    lights: &[AreaLight],
    (triangle, barycentrics): (u32, [f32; 2]),
    outward: Vec3,
    v: Vec3,
) -> Vec3 {
    let id = scene.triangle_light[triangle as usize];
    let light = lights.get(id as usize);
    light.map_or(Vec3::ZERO, |light| {
        light.emitted(outward, v) * scene.emitted_share(triangle, barycentrics)
    })
}
