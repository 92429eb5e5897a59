//! Portals: rectangles that the sky is seen through.

use crate::error::LightError;
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

/// A rectangle, sampled uniformly by the solid angle that it covers (Ureña, Fajardo, King,
/// *An Area-Preserving Parametrization for Spherical Rectangles*, EGSR 2013).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Portal {
    corner: DVec3,
    /// Unit and orthogonal: across, up, and their cross product.
    axes: [DVec3; 3],
    /// Lengths of the sides.
    size: [f64; 2],
}

/// The rectangle as one point sees it.
struct Seen {
    /// Coordinates of the sides from the point: left, right, bottom, top, and the plane's
    /// distance, negative.
    x: [f64; 2],
    y: [f64; 2],
    z: f64,
    /// The sides' normals' z at bottom and top, and what the sampler needs of the angles.
    b: [f64; 2],
    k: f64,
    solid_angle: f64,
    axes: [DVec3; 3],
}

impl Portal {
    /// By four corners in order, either way round.
    ///
    /// # Errors
    /// Corners that do not lie in a plane, sides that are not at right angles (to a thousandth),
    /// no area, or numbers that are not finite.
    pub fn new(corners: [Vec3; 4]) -> Result<Portal, LightError> {
        let [a, b, c, d] = corners.map(|p| p.as_dvec3());
        let (across, up) = (b - a, d - a);
        let (width, height) = (across.length(), up.length());
        let scale = width.max(height);
        let closes = (b + up - c).length() <= 1e-3 * scale;
        let square = across.dot(up).abs() <= 1e-3 * width * height;
        if !(width > 0.0 && height > 0.0 && scale.is_finite() && closes && square) {
            return Err(LightError::Portal);
        }
        let x = across / width;
        let y = (up - x * x.dot(up)).normalize();
        Ok(Portal {
            corner: a,
            axes: [x, y, x.cross(y)],
            size: [width, height],
        })
    }

    /// The corners.
    pub fn corners(&self) -> [Vec3; 4] {
        let (x, y) = (self.axes[0] * self.size[0], self.axes[1] * self.size[1]);
        [DVec3::ZERO, x, x + y, y].map(|offset| (self.corner + offset).as_vec3())
    }

    /// Unit normal, of either side.
    pub fn normal(&self) -> Vec3 {
        self.axes[2].as_vec3()
    }

    /// Solid angle \[sr\] that the portal covers from a point; 0 in its plane.
    pub fn solid_angle(&self, at: Vec3) -> f64 {
        self.seen(at).map_or(0.0, |seen| seen.solid_angle)
    }

    fn seen(&self, at: Vec3) -> Option<Seen> {
        let d = self.corner - at.as_dvec3();
        let mut axes = self.axes;
        let mut z = d.dot(axes[2]);
        if z > 0.0 {
            z = -z;
            axes[2] = -axes[2];
        }
        let scale = self.size[0].max(self.size[1]);
        if z > -1e-7 * scale {
            return None;
        }
        let (x0, y0) = (d.dot(axes[0]), d.dot(axes[1]));
        let (x, y) = ([x0, x0 + self.size[0]], [y0, y0 + self.size[1]]);
        let corner = |x: f64, y: f64| DVec3::new(x, y, z);
        let side = |a: DVec3, b: DVec3| a.cross(b).normalize();
        let n = [
            side(corner(x[0], y[0]), corner(x[1], y[0])),
            side(corner(x[1], y[0]), corner(x[1], y[1])),
            side(corner(x[1], y[1]), corner(x[0], y[1])),
            side(corner(x[0], y[1]), corner(x[0], y[0])),
        ];
        let angle = |i: usize| (-n[i].dot(n[(i + 1) % 4])).clamp(-1.0, 1.0).acos();
        let g = [angle(0), angle(1), angle(2), angle(3)];
        let k = 2.0 * PI - g[2] - g[3];
        let solid_angle = g[0] + g[1] - k;
        (solid_angle > 1e-12).then_some(Seen {
            x,
            y,
            z,
            b: [n[0].z, n[2].z],
            k,
            solid_angle,
            axes,
        })
    }

    /// A unit direction through the portal, uniform by solid angle, and the distance to it, from
    /// two numbers in [0, 1). Density 1 / [`Portal::solid_angle`]; `None` where it is 0.
    pub fn sample(&self, at: Vec3, u: [f32; 2]) -> Option<(Vec3, f32)> {
        let seen = self.seen(at)?;
        let [u, v] = u.map(f64::from);
        let au = u * seen.solid_angle + seen.k;
        let fu = (au.cos() * seen.b[0] - seen.b[1]) / au.sin();
        let cu = (1.0 / (fu * fu + seen.b[0] * seen.b[0]).sqrt())
            .copysign(fu)
            .clamp(-1.0, 1.0);
        let xu = (-(cu * seen.z) / (1.0 - cu * cu).max(1e-30).sqrt()).clamp(seen.x[0], seen.x[1]);
        let d = (xu * xu + seen.z * seen.z).sqrt();
        let h = seen.y.map(|y| y / (d * d + y * y).sqrt());
        let hv = h[0] + v * (h[1] - h[0]);
        let yv = if hv * hv < 1.0 - 1e-12 {
            hv * d / (1.0 - hv * hv).sqrt()
        } else {
            seen.y[1]
        };
        let to = seen.axes[0] * xu + seen.axes[1] * yv + seen.axes[2] * seen.z;
        let distance = to.length();
        Some(((to / distance).as_vec3(), distance as f32))
    }

    /// Distance to the portal in a unit direction, if it is met.
    pub fn hit(&self, at: Vec3, toward: Vec3) -> Option<f32> {
        let (d, w) = (self.corner - at.as_dvec3(), toward.as_dvec3());
        let distance = d.dot(self.axes[2]) / w.dot(self.axes[2]);
        let place = w * distance - d;
        let inside = |axis: usize| {
            let x = place.dot(self.axes[axis]);
            x >= 0.0 && x <= self.size[axis]
        };
        (distance > 0.0 && inside(0) && inside(1)).then_some(distance as f32)
    }
}
