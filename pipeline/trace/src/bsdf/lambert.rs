//! Ideal diffuse reflection: f = base colour / pi.

use super::Scatter;
use glam::Vec3;
use std::f32::consts::{FRAC_1_PI, PI};

/// f cos(theta_l).
#[inline(always)]
pub fn eval(base_color: Vec3, v: Vec3, l: Vec3) -> Vec3 {
    if v.z <= 0.0 {
        return Vec3::ZERO;
    }
    base_color * (l.z.max(0.0) * FRAC_1_PI)
}

/// Cosine-weighted direction from the last two of three numbers.
#[inline(always)]
pub fn sample(base_color: Vec3, v: Vec3, u: [f32; 3]) -> Scatter {
    let l = cosine_hemisphere([u[1], u[2]]);
    let pdf = pdf(v, l);
    let weight = if pdf > 0.0 { base_color } else { Vec3::ZERO };
    Scatter { l, weight, pdf }
}

/// cos(theta_l) / pi.
#[inline(always)]
pub fn pdf(v: Vec3, l: Vec3) -> f32 {
    if v.z <= 0.0 {
        return 0.0;
    }
    cosine_hemisphere_pdf(l)
}

/// A unit vector with density cos(theta) / pi with respect to solid angle
/// (Malley's method: a uniform disk lifted onto the hemisphere).
#[inline(always)]
pub fn cosine_hemisphere(u: [f32; 2]) -> Vec3 {
    let radius = u[0].sqrt();
    let (sine, cosine) = (2.0 * PI * u[1]).sin_cos();
    Vec3::new(radius * cosine, radius * sine, (1.0 - u[0]).max(0.0).sqrt())
}

/// Density of [`cosine_hemisphere`].
#[inline(always)]
pub fn cosine_hemisphere_pdf(l: Vec3) -> f32 {
    l.z.max(0.0) * FRAC_1_PI
}
