//! Ways in which the two ends of a path are joined, each with its share by the balance heuristic.

use super::emit::{End, Lights, Sent};
use super::eye::EyeVertex;
use super::light::{LIGHT_VERTICES, LightVertex, scattered, sent_to};
use crate::mirrors::NO_MIRROR;
use crate::tracer::Tracer;
use glam::Vec3;

/// Radiance that arrives by a path unless something is in between.
#[derive(Clone, Copy)]
pub(super) struct Joint {
    pub(super) value: Vec3,
    /// The shadow ray's origin, direction and end.
    pub(super) origin: Vec3,
    pub(super) direction: Vec3,
    pub(super) t_max: f32,
}

/// Joins a vertex of either end. A light vertex that a mirror led to is one that the light itself might have
/// led to: value over the sum of all densities, whichever it was.
pub(super) fn connect(tracer: &Tracer, x: &EyeVertex, z: &LightVertex) -> Option<Joint> {
    let apart = z.site.position - x.site.position;
    let distance2 = apart.length_squared();
    let l = apart.try_normalize()?;
    let (here, by_direction) = scattered(&x.site, x.viewer, l);
    let (there, onward) = scattered(&z.site, -l, z.toward);
    let [cos_x, cos_z] = [&x.site, &z.site].map(|site| site.outward.dot(l).abs());
    let value = x.throughput * here * there * z.arriving * (cos_z / distance2);
    if !value.is_finite() || value == Vec3::ZERO {
        return None;
    }
    let by_eye = by_direction * cos_z / distance2;
    let mut others = by_eye / z.density * (1.0 + z.earlier(onward, tracer));
    if z.number == 1 {
        others += z.mirrored(tracer, x.site.position);
    }
    let by_light = sent_to(&z.site, -l, z.toward) * cos_x / distance2;
    let most = LIGHT_VERTICES.saturating_sub(z.number as usize);
    others += x.lighter(l, by_light, most);
    let origin = x.site.origin(l);
    Some(Joint {
        value: value / (1.0 + others),
        origin,
        direction: z.site.origin(-l) - origin,
        t_max: 1.0,
    })
}

/// Joins a vertex to a light.
pub(super) fn next_event(
    tracer: &Tracer,
    lights: &Lights,
    x: &EyeVertex,
    end: &End,
) -> Option<Joint> {
    let sent = lights.sent(end, x.site.position)?;
    let choice = lights.choice(end, x.site.position);
    let (here, density) = scattered(&x.site, x.viewer, sent.toward);
    let value = x.throughput * here * sent.irradiance / choice;
    if !value.is_finite() || value == Vec3::ZERO {
        return None;
    }
    let by_direction = match sent.area_per_angle > 0.0 {
        true => density / (sent.area_per_angle * choice),
        false => 0.0,
    };
    let others = by_direction + by_the_light(tracer, x, end, &sent, choice);
    let origin = x.site.origin(sent.toward);
    let (direction, t_max) = lights.shadow(end, origin);
    Some(Joint {
        value: value / (1.0 + others),
        origin,
        direction,
        t_max,
    })
}

/// Radiance from a light that the direction to it, drawn with `density`, has met, for light that
/// the vertex sends on with `throughput`.
pub(super) fn met(
    tracer: &Tracer,
    lights: &Lights,
    x: &EyeVertex,
    (throughput, density): (Vec3, f32),
    end: &End,
) -> Vec3 {
    let Some(sent) = lights.sent(end, x.site.position) else {
        return Vec3::ZERO;
    };
    if sent.area_per_angle == 0.0 {
        return Vec3::ZERO;
    }
    let radiance = sent.irradiance * sent.area_per_angle;
    let choice = lights.choice(end, x.site.position);
    let by_choice = choice * sent.area_per_angle / density;
    let others = if choice > 0.0 {
        by_choice * (1.0 + by_the_light(tracer, x, end, &sent, choice))
    } else {
        0.0
    };
    throughput * radiance / (1.0 + others)
}

/// The sum over the ways in which x and more belong to the light's end, or a mirror led to x, relative to
/// that of [`next_event`].
fn by_the_light(tracer: &Tracer, x: &EyeVertex, end: &End, sent: &Sent, choice: f32) -> f32 {
    let emit = end.emit / choice;
    let leave = sent.leave * x.site.outward.dot(sent.toward).abs();
    let mut sum = x.lighter(sent.toward, emit * leave, LIGHT_VERTICES);
    let mirror = tracer.mirrors.of(x.triangle);
    if mirror != NO_MIRROR && x.number > 0 {
        let y = (x.site.position, x.site.outward);
        let density = (tracer.mirrors).density_any(mirror, x.from, end.shown(), y);
        sum += emit * density / x.density;
    }
    sum
}
