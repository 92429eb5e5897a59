//! One ray, and what it meets.

use glam::Vec3;

/// A ray origin + t direction, 0 < t < t_max, in world space.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    pub origin: Vec3,
    pub direction: Vec3,
    pub t_max: f32,
}

/// The end of a ray: the scene id ([`rrf_scene::INVALID`] for nothing), distance and barycentrics of the
/// second and third corner.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    pub triangle: u32,
    pub t: f32,
    pub barycentrics: [f32; 2],
}
