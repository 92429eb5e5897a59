//! Orthonormal axes about a direction.

use glam::Vec3;

/// Orthonormal axes at a surface point, right-handed: x by y is z, and z the normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadingFrame {
    /// First tangent.
    pub x: Vec3,
    /// Second tangent.
    pub y: Vec3,
    /// Normal.
    pub z: Vec3,
}

impl ShadingFrame {
    /// Tangents for a unit normal without branches on its direction
    /// (Duff et al., *Building an Orthonormal Basis, Revisited*, JCGT 2017).
    #[inline(always)]
    pub fn new(z: Vec3) -> ShadingFrame {
        let sign = 1.0f32.copysign(z.z);
        let a = -1.0 / (sign + z.z);
        let b = z.x * z.y * a;
        ShadingFrame {
            x: Vec3::new(1.0 + sign * z.x * z.x * a, sign * b, -sign * z.x),
            y: Vec3::new(b, sign + z.y * z.y * a, -z.y),
            z,
        }
    }

    /// A world direction in this frame.
    #[inline(always)]
    pub fn to_local(&self, w: Vec3) -> Vec3 {
        Vec3::new(w.dot(self.x), w.dot(self.y), w.dot(self.z))
    }

    /// A direction of this frame in the world.
    #[inline(always)]
    pub fn to_world(&self, w: Vec3) -> Vec3 {
        self.x * w.x + self.y * w.y + self.z * w.z
    }
}
