//! Ideal diffuse reflection: f = base colour / pi.

use super::{Bsdf, Scatter};
use crate::math::{pick, sin_cos_turn};
use crate::surface::Frame;
use glam::Vec3;
use std::f32::consts::FRAC_1_PI;

/// f cos(theta_l).
#[inline(always)]
pub fn eval(bsdf: &Bsdf, n: Vec3, v: Vec3, l: Vec3) -> Vec3 {
    bsdf.base_color * pdf(n, v, l)
}

/// A cosine-weighted direction from the last two of three numbers.
#[inline(always)]
pub fn sample(bsdf: &Bsdf, n: Vec3, v: Vec3, u: [f32; 3]) -> Scatter {
    let l = Frame::new(n).to_world(cosine_hemisphere([u[1], u[2]]));
    let pdf = pdf(n, v, l);
    Scatter {
        l,
        weight: pick(pdf > 0.0, bsdf.base_color, Vec3::ZERO),
        pdf,
    }
}

/// cos(theta_l) / pi above the surface.
#[inline(always)]
pub fn pdf(n: Vec3, v: Vec3, l: Vec3) -> f32 {
    if n.dot(v) > 0.0 {
        cosine_hemisphere_pdf(n.dot(l))
    } else {
        0.0
    }
}

/// A unit vector about (0, 0, 1) with density cos(theta) / pi with respect to solid angle
/// (Malley's method: a uniform disk lifted onto the hemisphere).
#[inline(always)]
pub fn cosine_hemisphere(u: [f32; 2]) -> Vec3 {
    let radius = u[0].sqrt();
    let (sine, cosine) = sin_cos_turn(u[1]);
    Vec3::new(radius * cosine, radius * sine, (1.0 - u[0]).sqrt())
}

/// Density of [`cosine_hemisphere`] from cos(theta).
#[inline(always)]
pub fn cosine_hemisphere_pdf(cosine: f32) -> f32 {
    if cosine > 0.0 {
        cosine * FRAC_1_PI
    } else {
        0.0
    }
}
