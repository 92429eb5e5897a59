//! Samplers of simple domains, each beside its density.

use glam::Vec3;
use std::f32::consts::{PI, TAU};

/// A direction uniform over the sphere, from two numbers in [0, 1).
pub fn uniform_sphere(u: [f32; 2]) -> Vec3 {
    let z = 1.0 - 2.0 * u[0];
    let radius = (1.0 - z * z).max(0.0).sqrt();
    let (sine, cosine) = (TAU * u[1]).sin_cos();
    Vec3::new(radius * cosine, radius * sine, z)
}

/// Density of [`uniform_sphere`] with respect to solid angle [1/sr].
pub const UNIFORM_SPHERE_DENSITY: f32 = 1.0 / (4.0 * PI);

/// A direction uniform over the cone about +z whose half angle has 1 - cos = `spread`, from two
/// numbers in [0, 1). The spread stands in place of the cosine, so that narrow cones keep their
/// precision.
pub fn uniform_cone(u: [f32; 2], spread: f32) -> Vec3 {
    let drop = spread * u[0];
    let radius = (drop * (2.0 - drop)).max(0.0).sqrt();
    let (sine, cosine) = (TAU * u[1]).sin_cos();
    Vec3::new(radius * cosine, radius * sine, 1.0 - drop)
}

/// Density of [`uniform_cone`] with respect to solid angle [1/sr], inside the cone.
pub fn uniform_cone_density(spread: f32) -> f32 {
    1.0 / (TAU * spread)
}

/// 1 - cos of a half angle in radians, precise for small angles: 2 sin²(angle / 2).
pub fn spread_of(half_angle: f64) -> f32 {
    let sine = (0.5 * half_angle).sin();
    (2.0 * sine * sine) as f32
}

/// 1 - cos of the angle between two unit directions: half the squared chord, precise where they
/// are close.
pub fn spread_between(a: Vec3, b: Vec3) -> f32 {
    0.5 * (a - b).length_squared()
}

/// Turns a direction about +z into one about the unit direction `axis`.
pub fn about(axis: Vec3, local: Vec3) -> Vec3 {
    let (x, y) = axis.any_orthonormal_pair();
    x * local.x + y * local.y + axis * local.z
}
