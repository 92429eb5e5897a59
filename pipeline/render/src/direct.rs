//! Direct light of point lights: exact, one shadow ray a light.

use crate::tile::Visible;
use glam::Vec3;
use rrf_field::columns;
use rrf_scene::PointLight;
use rrf_trace::{Rays, Tracer};

/// Working columns, made once a thread.
#[derive(Clone, Debug, Default)]
pub struct Direct {
    /// Radiance [W·sr⁻¹·m⁻²] of each visible point after [`Direct::point_lights`].
    pub radiance: Vec<Vec3>,
    rays: Rays,
    blocked: Vec<bool>,
    /// Row and unoccluded radiance of each shadow ray.
    arriving: Vec<(u32, Vec3)>,
}

impl Direct {
    /// What each visible point sends to its viewer straight from the lights:
    /// Σ_k I_k f(v, l_k) cos θ_k V(x, l_k) / ‖l_k − x‖². A light on the surface itself lights it
    /// from no direction.
    pub fn point_lights(&mut self, tracer: &Tracer, seen: &Visible, lights: &[PointLight]) {
        self.radiance.clear();
        self.radiance.resize(seen.points.len(), Vec3::ZERO);
        for light in lights {
            self.arrive(tracer, seen, light);
            tracer.occluded(&self.rays, &mut self.blocked);
            for (&(row, radiance), &blocked) in self.arriving.iter().zip(&self.blocked) {
                if !blocked {
                    self.radiance[row as usize] += radiance;
                }
            }
        }
    }

    /// Shadow rays to a light from the rows that it can light.
    fn arrive(&mut self, tracer: &Tracer, seen: &Visible, light: &PointLight) {
        self.rays.clear();
        self.arriving.clear();
        for (row, point) in seen.points.iter().enumerate() {
            let (to, v) = (light.position - point.position, seen.viewer(row));
            let l = to.normalize_or_zero();
            // Light passes no surface: light and viewer are on the same side of the triangle.
            if point.normal.dot(l) * point.normal.dot(v) <= 0.0 {
                continue;
            }
            let normal = seen.rows.vec3(columns::N, row).into();
            let value = tracer.material_at(point).eval(normal, v, l);
            if value == Vec3::ZERO {
                continue;
            }
            let radiance = light.intensity * value / to.length_squared();
            self.arriving.push((row as u32, radiance));
            let origin = tracer.lift(point.triangle, point.position, v);
            self.rays.push(origin, light.position - origin, 1.0);
        }
    }
}
