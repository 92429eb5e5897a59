//! Direct light of point lights: exact, one shadow ray a light.

use glam::Vec3;
use rrf_scene::PointLight;
use rrf_trace::{SurfacePoint, Tracer};

/// Radiance [W·sr⁻¹·m⁻²] that `point` sends to `v` straight from the lights:
/// Σ_k I_k f(v, l_k) cos θ_k V(x, l_k) / ‖l_k − x‖².
pub fn point_lights(tracer: &Tracer, point: &SurfacePoint, v: Vec3, lights: &[PointLight]) -> Vec3 {
    let (frame, bsdf) = (tracer.frame_at(point, v), tracer.material_at(point));
    let local = frame.to_local(v);
    let mut sum = Vec3::ZERO;
    for light in lights {
        let to = light.position - point.position;
        let distance2 = to.length_squared();
        if distance2 == 0.0 {
            continue; // a light on the surface itself lights it from no direction
        }
        let l = to / distance2.sqrt();
        let value = bsdf.eval(local, frame.to_local(l));
        if value == Vec3::ZERO {
            continue;
        }
        let origin = tracer.lift(point.triangle, point.position, l);
        if !tracer.occluded(origin, light.position - origin, 1.0) {
            sum += light.intensity * value / distance2;
        }
    }
    sum
}
