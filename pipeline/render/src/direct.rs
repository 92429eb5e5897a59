//! Direct light of point lights: exact, one shadow ray a light.

use crate::tile::Visible;
use glam::Vec3;
use rrf_field::columns;
use rrf_scene::PointLight;
use rrf_trace::{Rays, Tracer};

/// Radiance [W·sr⁻¹·m⁻²] that each visible point sends to its viewer straight from the lights:
/// Σ_k I_k f(v, l_k) cos θ_k V(x, l_k) / ‖l_k − x‖². A light on the surface itself lights it
/// from no direction.
pub fn point_lights(tracer: &Tracer, seen: &Visible, lights: &[PointLight]) -> Vec<Vec3> {
    let mut sums = vec![Vec3::ZERO; seen.points.len()];
    let (mut rays, mut blocked) = (Rays::default(), Vec::new());
    let mut arriving: Vec<(u32, Vec3)> = Vec::new();
    for light in lights {
        rays.clear();
        arriving.clear();
        for (row, point) in seen.points.iter().enumerate() {
            let to = light.position - point.position;
            let distance2 = to.length_squared();
            let Some(l) = to.try_normalize() else {
                continue;
            };
            let normal = seen.rows.vec3(columns::N, row).into();
            let value = tracer.material_at(point).eval(normal, seen.viewer(row), l);
            if value != Vec3::ZERO {
                arriving.push((row as u32, light.intensity * value / distance2));
                let origin = tracer.lift(point.triangle, point.position, l);
                rays.push(origin, light.position - origin, 1.0);
            }
        }
        tracer.occluded(&rays, &mut blocked);
        for (&(row, radiance), &blocked) in arriving.iter().zip(&blocked) {
            if !blocked {
                sums[row as usize] += radiance;
            }
        }
    }
    sums
}
