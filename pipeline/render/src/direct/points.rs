//! Direct light of points and of parallel light: exact, one shadow ray a light.

use crate::tile::VisiblePoints;
use crate::timings::{FrameStage, Stopwatch};
use glam::Vec3;
use rrf_lights::LightSource;
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
    /// from no direction. `sharp` are lights that shine from one direction each.
    pub fn shade(
        &mut self,
        tracer: &Tracer,
        seen: &VisiblePoints,
        (lights, sharp): (&[PointLight], &[&LightSource]),
        watch: &mut Stopwatch,
    ) {
        self.radiance.clear();
        self.radiance.resize(seen.points.len(), Vec3::ZERO);
        for light in lights {
            self.arrive(tracer, seen, light);
            self.gather(tracer, watch);
        }
        for light in sharp {
            self.arrive_from(tracer, seen, light);
            self.gather(tracer, watch);
        }
        watch.end(FrameStage::Direct);
    }

    /// Adds what arrives along the shadow rays that nothing blocks.
    fn gather(&mut self, tracer: &Tracer, watch: &mut Stopwatch) {
        watch.end(FrameStage::Direct);
        tracer.occluded(&self.rays, &mut self.blocked);
        watch.end(FrameStage::ShadowRays);
        for (&(row, radiance), &blocked) in self.arriving.iter().zip(&self.blocked) {
            if !blocked {
                self.radiance[row as usize] += radiance;
            }
        }
    }

    /// Shadow rays to a light of any sharp kind.
    fn arrive_from(&mut self, tracer: &Tracer, seen: &VisiblePoints, light: &LightSource) {
        self.rays.clear();
        self.arriving.clear();
        let surface = seen.points.iter().zip(&seen.normals).zip(&seen.viewers);
        for (row, ((point, &normal), &v)) in surface.enumerate() {
            let Some(arrival) = light.sample(point.position, [0.5; 2]) else {
                continue;
            };
            let l = arrival.toward;
            if point.normal.dot(l) * point.normal.dot(v) <= 0.0 {
                continue;
            }
            let radiance = arrival.irradiance * seen.under_lights(row).eval(normal, v, l);
            if radiance == Vec3::ZERO {
                continue;
            }
            self.arriving.push((row as u32, radiance));
            let origin = tracer.lift(point.triangle, point.position, v);
            match light.position() {
                Some(position) => self.rays.push(origin, position - origin, 1.0),
                None => self.rays.push(origin, l, f32::INFINITY),
            }
        }
    }

    /// Shadow rays to a light from the rows that it can light.
    fn arrive(&mut self, tracer: &Tracer, seen: &VisiblePoints, light: &PointLight) {
        self.rays.clear();
        self.arriving.clear();
        let surface = seen.points.iter().zip(&seen.normals).zip(&seen.viewers);
        for (row, ((point, &normal), &v)) in surface.enumerate() {
            let to = light.position - point.position;
            // Light passes no surface: light and viewer are on the same side of the triangle.
            if point.normal.dot(to) * point.normal.dot(v) <= 0.0 {
                continue;
            }
            let squared = to.length_squared();
            if squared < f32::MIN_POSITIVE {
                continue;
            }
            let value = (seen.under_lights(row)).eval(normal, v, to / squared.sqrt());
            if value == Vec3::ZERO {
                continue;
            }
            self.arriving
                .push((row as u32, light.intensity * value / squared));
            let origin = tracer.lift(point.triangle, point.position, v);
            self.rays.push(origin, light.position - origin, 1.0);
        }
    }
}
