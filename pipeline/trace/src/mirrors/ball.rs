//! Polished balls, and the image of a light in one.

use super::image::Shown;
use crate::facets::Facet;
use glam::{DMat3, DVec3, Vec2, Vec3};
use rrf_materials::Lobe;
use rrf_scene::Scene;
use std::f32::consts::PI;

/// Balls at the most: each is asked at every vertex.
pub(super) const MOST_BALLS: usize = 4;
/// How far, relative to the radius, corners and their normals may be from a sphere's.
const ROUND: f32 = 1e-2;
/// Cosine of the angle at which light is reflected below which an image is left out.
const LEAST_COSINE: f32 = 0.02;
/// Steps of the search for the image.
const STEPS: usize = 6;

/// A convex mirror: most of a sphere's triangles.
#[derive(Clone, Debug)]
pub(super) struct Ball {
    center: Vec3,
    radius: f32,
    /// Width that the image's slopes are drawn with: GGX alpha, and what flat triangles add.
    alpha: f32,
    reflectance: f32,
}

/// The image of a light in a ball, as the tangent plane there has it.
pub(super) struct BallImage {
    /// Where, and the unit normal there.
    pub(super) center: Vec3,
    pub(super) normal: Vec3,
    /// Unit vectors along and across the plane of incidence.
    pub(super) axes: [Vec3; 2],
    /// Slopes of the half vector against the ball's normal, a metre.
    pub(super) slopes: Vec2,
    /// Irradiance by way of the ball, over that of the light without any way.
    pub(super) weight: f32,
}

impl Ball {
    #[cfg(test)]
    pub(super) fn new(center: Vec3, radius: f32, alpha: f32, reflectance: f32) -> Ball {
        Ball {
            center,
            radius,
            alpha,
            reflectance,
        }
    }

    /// The image of `l` as `x` sees it; the angle from x's side, φ, solves: angle of incidence is angle
    /// of reflection.
    pub(super) fn image(&self, x: Vec3, l: Shown) -> Option<BallImage> {
        let to_x = x - self.center;
        let to_l = l.at - self.center * l.w;
        let (far_x, far_l) = (to_x.length() / self.radius, to_l.length() / self.radius);
        let outside = |far: f32| far > 1.0 + 1e-3;
        if !outside(far_x) || l.w > 0.0 && !outside(far_l) {
            return None;
        }
        let (along_x, along_l) = (to_x.normalize(), to_l.try_normalize()?);
        let across = along_l.reject_from_normalized(along_x);
        let between = across.length().atan2(along_x.dot(along_l));
        let across = across
            .try_normalize()
            .unwrap_or_else(|| along_x.any_orthonormal_vector());
        let mut angle = 0.5 * between;
        for _ in 0..STEPS {
            let (i, di) = incidence(far_x, angle);
            let (o, d_o) = match l.w > 0.0 {
                true => incidence(far_l, between - angle),
                false => (between - angle, 1.0),
            };
            angle = (angle - (i - o) / (di + d_o)).clamp(0.0, between);
        }
        let (sine, cosine) = angle.sin_cos();
        let normal = along_x * cosine + across * sine;
        let center = self.center + normal * self.radius;
        let back = x - center;
        let near = back.length();
        let cosine = normal.dot(back) / near;
        let onward = l.at - center * l.w;
        let reach = onward.length();
        if cosine < LEAST_COSINE || normal.dot(onward) < LEAST_COSINE * reach {
            return None;
        }
        let inverse = if l.w > 0.0 { 1.0 / reach } else { 0.0 };
        let k = 0.5 * (1.0 / near + inverse) / cosine;
        let bend = 1.0 / self.radius;
        let slopes = Vec2::new(k * cosine * cosine + bend, k + bend);
        let spread = 4.0 * near * near * slopes.x * slopes.y;
        let squared = if l.w > 0.0 { reach * reach } else { 1.0 };
        let first = back.reject_from_normalized(normal).try_normalize();
        let first = first.unwrap_or_else(|| normal.any_orthonormal_vector());
        Some(BallImage {
            center,
            normal,
            axes: [first, normal.cross(first)],
            slopes,
            weight: self.reflectance / (spread * squared),
        })
    }
}

/// Angle at which a point at `far` radii from the middle sees the normal at `angle` from its own, and
/// its derivative.
fn incidence(far: f32, angle: f32) -> (f32, f32) {
    let (sine, cosine) = angle.sin_cos();
    let squared = far * far - 2.0 * far * cosine + 1.0;
    let value = (far * sine).atan2(far * cosine - 1.0);
    (value, far * (far - cosine) / squared)
}

impl BallImage {
    /// A point of the tangent plane, by GGX slopes.
    pub(super) fn sample(&self, ball: &Ball, u: [f32; 2]) -> Vec3 {
        let radius = ball.alpha * (u[0] / (1.0 - u[0])).sqrt();
        let (sine, cosine) = rrf_materials::math::sin_cos_turn(u[1]);
        let d = Vec2::new(radius * cosine, radius * sine) / self.slopes;
        self.center + self.axes[0] * d.x + self.axes[1] * d.y
    }

    /// Density of a ray from `x` to [`BallImage::sample`] at `y`, a point of a surface with this unit
    /// normal, with respect to area there.
    pub(super) fn density(&self, ball: &Ball, x: Vec3, (y, outward): (Vec3, Vec3)) -> f32 {
        let way = y - x;
        let distance2 = way.length_squared();
        let direction = way / distance2.sqrt();
        let falls = -self.normal.dot(direction);
        let t = self.normal.dot(x - self.center) / falls;
        if falls <= 0.0 || t <= 0.0 {
            return 0.0;
        }
        let d = x + direction * t - self.center;
        let slope = Vec2::new(d.dot(self.axes[0]), d.dot(self.axes[1])) * self.slopes;
        let alpha2 = ball.alpha * ball.alpha;
        let spread = 1.0 + slope.length_squared() / alpha2;
        let in_plane = self.slopes.x * self.slopes.y / (PI * alpha2 * spread * spread);
        in_plane * t * t / falls * outward.dot(direction).abs() / distance2
    }
}

impl Ball {
    /// The ball that triangles with this lobe make, if they do.
    pub(super) fn over(scene: &Scene, facets: &[Facet], ids: &[usize], lobe: Lobe) -> Option<Ball> {
        let corners = || ids.iter().flat_map(|&id| scene.triangles[id]);
        let places = || corners().map(|v| scene.positions[v as usize].as_dvec3());
        let center = sphere_center(places())?.as_vec3();
        let count = places().count() as f32;
        let far = |v: u32| scene.positions[v as usize].distance(center);
        let radius = corners().map(far).sum::<f32>() / count;
        let is_round = |v: u32| {
            let out = (scene.positions[v as usize] - center) / radius;
            let normal = scene.normals[v as usize].normalize_or_zero();
            (out.length() - 1.0).abs() < ROUND && (normal - out).length() < 3.0 * ROUND
        };
        if !(radius > 0.0 && corners().all(is_round)) {
            return None;
        }
        // how deep the triangles lie below the sphere turns their normals from where rays expect them
        let depth = ids.iter().map(|&id| {
            let facet = &facets[id];
            1.0 - (facet.corner - center).dot(facet.normal).abs() / radius
        });
        let depth = depth.fold(0.0, f32::max);
        Some(Ball {
            center,
            radius,
            alpha: lobe.alpha + depth,
            reflectance: lobe.reflectance,
        })
    }
}

/// The middle of the sphere that points lie on, by least squares: |p|² = 2 c·p + const.
fn sphere_center(points: impl Iterator<Item = DVec3> + Clone) -> Option<DVec3> {
    let count = points.clone().count() as f64;
    let mean = points.clone().sum::<DVec3>() / count;
    let mean_square = points
        .clone()
        .map(|p| (p - mean).length_squared())
        .sum::<f64>()
        / count;
    let (mut matrix, mut right) = (DMat3::ZERO, DVec3::ZERO);
    for p in points {
        let d = p - mean;
        matrix += DMat3::from_cols(d * d.x, d * d.y, d * d.z);
        right += d * (0.5 * (d.length_squared() - mean_square));
    }
    let size = matrix.determinant().abs().cbrt();
    (size > 1e-6 * mean_square * count).then(|| mean + matrix.inverse() * right)
}
