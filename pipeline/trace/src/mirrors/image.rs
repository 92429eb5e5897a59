//! One mirror, and the image of a light in it.

use glam::{Vec2, Vec3};
use std::f32::consts::PI;

/// The light that mirrors show: a point, or a direction that light comes from, as homogeneous
/// coordinates.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shown {
    /// Position, or unit direction.
    pub(crate) at: Vec3,
    /// 1 for a position, 0 for a direction.
    pub(crate) w: f32,
}

impl Shown {
    /// A point.
    #[inline]
    pub(crate) fn point(at: Vec3) -> Shown {
        Shown { at, w: 1.0 }
    }

    /// Light from infinitely far away.
    #[inline]
    pub(crate) fn far_end(toward: Vec3) -> Shown {
        Shown { at: toward, w: 0.0 }
    }
}

/// A flat glossy surface.
#[derive(Clone, Debug)]
pub(super) struct Mirror {
    /// Its plane: normal · y = offset.
    pub(super) normal: Vec3,
    pub(super) offset: f32,
    /// Axes in the plane, and the bounds along them.
    pub(super) axes: [Vec3; 2],
    pub(super) low: Vec2,
    pub(super) high: Vec2,
    /// GGX alpha.
    pub(super) alpha: f32,
    /// Reflectance at normal incidence.
    pub(super) reflectance: f32,
}

/// The image of a light in one mirror.
pub(super) struct Image {
    /// Where in the plane.
    pub(super) center: Vec2,
    /// Unit vector along the plane of incidence.
    pub(super) along: Vec2,
    /// Slopes a metre, along and across.
    pub(super) slopes: Vec2,
}

impl Mirror {
    /// Signed height over the plane.
    pub(super) fn height(&self, x: Vec3) -> f32 {
        self.normal.dot(x) - self.offset
    }

    pub(super) fn coordinates(&self, y: Vec3) -> Vec2 {
        Vec2::new(self.axes[0].dot(y), self.axes[1].dot(y))
    }

    pub(super) fn at(&self, y: Vec2) -> Vec3 {
        self.axes[0] * y.x + self.axes[1] * y.y + self.normal * self.offset
    }

    /// The image of `l` as `x` sees it, both on one side of the plane.
    pub(super) fn image(&self, x: Vec3, l: Shown) -> Image {
        let (a, b) = (self.height(x), self.normal.dot(l.at) - l.w * self.offset);
        let (from, to) = (self.coordinates(x), self.coordinates(l.at));
        let (apart, height) = (to - from * l.w, a * l.w + b);
        let distance2 = apart.length_squared() + height * height;
        let k = (height / (2.0 * a * b)).abs();
        Image {
            center: from + apart * (a / height),
            along: apart.try_normalize().unwrap_or(Vec2::X),
            slopes: Vec2::new(k * height * height / distance2, k),
        }
    }
}

impl Image {
    /// Slope of the half vector at `y`, along and across, to first order.
    pub(super) fn slope(&self, y: Vec2) -> Vec2 {
        let d = y - self.center;
        Vec2::new(d.dot(self.along), d.dot(self.along.perp())) * self.slopes
    }

    /// GGX slopes: density 1 / (π α² (1 + s²/α²)²).
    pub(super) fn sample(&self, alpha: f32, u: [f32; 2]) -> Vec2 {
        let radius = alpha * (u[0] / (1.0 - u[0])).sqrt();
        let (sine, cosine) = rrf_materials::math::sin_cos_turn(u[1]);
        let d = Vec2::new(radius * cosine, radius * sine) / self.slopes;
        self.center + self.along * d.x + self.along.perp() * d.y
    }

    /// Density of [`Image::sample`] with respect to area.
    pub(super) fn density(&self, alpha: f32, y: Vec2) -> f32 {
        let spread = 1.0 + self.slope(y).length_squared() / (alpha * alpha);
        self.slopes.x * self.slopes.y / (PI * alpha * alpha * spread * spread)
    }
}
