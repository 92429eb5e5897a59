//! The triangles that emit, chosen by their power.

use glam::Vec3;
use rrf_sampling::warp::{by_weight, uniform_triangle};
use rrf_scene::{INVALID, Scene};

/// The scene's emitting triangles.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lamps {
    triangles: Vec<u32>,
    /// Cumulative power of `triangles`, up to a common factor.
    cdf: Vec<f64>,
    /// Density of [`Lamps::sample`] on each scene triangle, with respect to area [1/m^2]; zero
    /// where nothing is emitted.
    density: Vec<f32>,
}

/// A point on a lamp.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LampPoint {
    pub(crate) triangle: u32,
    pub(crate) barycentrics: [f32; 2],
}

impl Lamps {
    /// `area_cdf` is the cumulative area of the scene's triangles.
    pub(crate) fn new(scene: &Scene, area_cdf: &[f64]) -> Lamps {
        let mut lamps = Lamps {
            density: vec![0.0; scene.triangles.len()],
            ..Lamps::default()
        };
        let (mut total, mut before) = (0.0, 0.0);
        let mut weights = Vec::new();
        for (id, (&light, &upto)) in scene.triangle_light.iter().zip(area_cdf).enumerate() {
            let area = upto - before;
            before = upto;
            let Some(light) = scene.area_lights.get(light as usize) else {
                continue;
            };
            let sides = if light.two_sided { 2.0 } else { 1.0 };
            let weight = f64::from(light.radiance.element_sum()) * sides;
            if weight * area > 0.0 {
                total += weight * area;
                lamps.triangles.push(id as u32);
                lamps.cdf.push(total);
                weights.push(weight);
            }
        }
        for (&triangle, weight) in lamps.triangles.iter().zip(weights) {
            lamps.density[triangle as usize] = (weight / total) as f32;
        }
        lamps
    }

    /// Whether nothing emits.
    pub(crate) fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// A point by emitted power, uniform by area on each triangle; `None` without lamps.
    pub(crate) fn sample(&self, u: [f32; 3]) -> Option<LampPoint> {
        let triangle = *self.triangles.get(by_weight(&self.cdf, u[0]))?;
        Some(LampPoint {
            triangle,
            barycentrics: uniform_triangle([u[1], u[2]]),
        })
    }

    /// Density of [`Lamps::sample`] on a triangle with respect to area [1/m^2].
    #[inline(always)]
    pub(crate) fn density(&self, triangle: u32) -> f32 {
        self.density[triangle as usize]
    }
}

/// Radiance that a triangle of the scene emits toward `v` [W/(sr m^2)]; `outward` is its
/// geometric normal.
#[inline]
pub(crate) fn emission(scene: &Scene, triangle: u32, outward: Vec3, v: Vec3) -> Vec3 {
    let id = scene.triangle_light[triangle as usize];
    if id == INVALID {
        return Vec3::ZERO;
    }
    let light = &scene.area_lights[id as usize];
    if light.two_sided || outward.dot(v) > 0.0 {
        light.radiance
    } else {
        Vec3::ZERO
    }
}
