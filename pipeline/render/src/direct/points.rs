//! PointLighting light of point lights: exact, one shadow ray a light.

use crate::tile::VisiblePoints;
use crate::timings::{FrameStage, Stopwatch};
use glam::Vec3;
use rrf_scene::PointLight;
use rrf_trace::{Rays, Tracer};

/// Working columns, made once a thread.
#[derive(Clone, Debug, Default)]
pub struct PointLighting {
    /// Radiance [W·sr⁻¹·m⁻²] of each visible point after [`PointLighting::shade`].
    pub radiance: Vec<Vec3>,
    rays: Rays,
    blocked: Vec<bool>,
    /// Row and unoccluded radiance of each shadow ray.
    arriving: Vec<(u32, Vec3)>,
}

impl PointLighting {
    /// Computes the light that each visible point sends to its viewer straight from the lights:
    /// Σ_k I_k f(v, l_k) cos θ_k V(x, l_k) / ‖l_k − x‖². A light on the surface itself lights it
    /// from no direction.
    pub fn shade(
        &mut self,
        tracer: &Tracer,
        seen: &VisiblePoints,
        lights: &[PointLight],
        watch: &mut Stopwatch,
    ) {
        self.radiance.clear();
        self.radiance.resize(seen.points.len(), Vec3::ZERO);
        for light in lights {
            self.arrive(tracer, seen, light);
            watch.end(FrameStage::Direct);
            tracer.occluded(&self.rays, &mut self.blocked);
            watch.end(FrameStage::ShadowRays);
            for (&(row, radiance), &blocked) in self.arriving.iter().zip(&self.blocked) {
                if !blocked {
                    self.radiance[row as usize] += radiance;
                }
            }
        }
        watch.end(FrameStage::Direct);
    }

    /// Shadow rays to a light from the rows that it can light.
    fn arrive(&mut self, tracer: &Tracer, seen: &VisiblePoints, light: &PointLight) {
        self.rays.clear();
        self.arriving.clear();
        let surface = seen.points.iter().zip(&seen.normals);
        let surface = surface.zip(seen.viewers.iter().zip(&seen.materials));
        for (row, ((point, &normal), (&v, material))) in (0u32..).zip(surface) {
            let to = light.position - point.position;
            // Light passes no surface: light and viewer are on the same side of the triangle.
            if point.normal.dot(to) * point.normal.dot(v) <= 0.0 {
                continue;
            }
            let squared = to.length_squared();
            if squared < f32::MIN_POSITIVE {
                continue;
            }
            let value = material.eval(normal, v, to / squared.sqrt());
            if value == Vec3::ZERO {
                continue;
            }
            self.arriving.push((row, light.intensity * value / squared));
            let origin = tracer.lift(point.triangle, point.position, v);
            self.rays.push(origin, light.position - origin, 1.0);
        }
    }
}
