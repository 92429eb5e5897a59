//! The GGX microfacet distribution with separable Smith masking (Walter et al. 2007).

use crate::math::sin_cos_turn;
use glam::Vec3;
use std::f32::consts::FRAC_1_PI;

/// Smallest GGX alpha.
const ALPHA_MIN: f32 = 0.001;

/// A microfacet normal about (0, 0, 1), one that a viewer in direction `v` sees
/// (Heitz 2018; spherical caps of Dupuy and Benyoub, HPG 2023).
#[inline(always)]
pub fn visible_normal(v: Vec3, alpha: f32, u: [f32; 2]) -> Vec3 {
    let stretched = Vec3::new(v.x * alpha, v.y * alpha, v.z).normalize();
    let z = (1.0 - u[1]) * (1.0 + stretched.z) - stretched.z;
    let radius = (1.0 - z * z).max(0.0).sqrt();
    let (sine, cosine) = sin_cos_turn(u[0]);
    let cap = Vec3::new(radius * cosine, radius * sine, z) + stretched;
    Vec3::new(cap.x * alpha, cap.y * alpha, cap.z).normalize()
}

/// Density of [`visible_normal`] at `h` with respect to solid angle.
pub fn visible_normal_pdf(v: Vec3, alpha: f32, h: Vec3) -> f32 {
    let half = Half {
        sin2: h.x * h.x + h.y * h.y,
        cos2: h.z * h.z,
        cos_d: v.dot(h),
    };
    if h.z > 0.0 && half.cos_d > 0.0 && v.z > 0.0 {
        visible_normal_density(&half, v.z, alpha)
    } else {
        0.0
    }
}

/// D_v(h) = G1(v) v.h D(h) / cos(theta_v).
#[inline(always)]
pub(crate) fn visible_normal_density(half: &Half, cos_v: f32, alpha: f32) -> f32 {
    smith(cos_v, alpha) * half.cos_d * ggx(half, alpha) / cos_v
}

/// The half vector h of v and l by what the lobes need of it.
pub(crate) struct Half {
    /// sin^2 and cos^2 of its angle to the normal.
    pub(crate) sin2: f32,
    pub(crate) cos2: f32,
    /// v.h = l.h
    pub(crate) cos_d: f32,
}

impl Half {
    #[inline(always)]
    pub(crate) fn new(n: Vec3, v: Vec3, l: Vec3) -> Half {
        Half::along(n, v, v + l)
    }

    /// The half vector along `sum`.
    #[inline(always)]
    pub(crate) fn along(n: Vec3, v: Vec3, sum: Vec3) -> Half {
        let length2 = sum.length_squared().max(f32::MIN_POSITIVE);
        let cosine = n.dot(sum);
        // By the cross product: 1 - cos^2 would lose a narrow lobe's digits.
        Half {
            sin2: n.cross(sum).length_squared() / length2,
            cos2: cosine * cosine / length2,
            cos_d: (v.dot(sum) / length2.sqrt()).max(f32::MIN_POSITIVE),
        }
    }
}

/// GGX alpha of a perceptual roughness.
#[inline(always)]
pub(crate) fn alpha(roughness: f32) -> f32 {
    (roughness * roughness).max(ALPHA_MIN)
}

/// GGX density of microfacet normals [1/sr] (Walter et al. 2007, eq. 33).
#[inline(always)]
pub(crate) fn ggx(half: &Half, alpha: f32) -> f32 {
    let alpha2 = alpha * alpha;
    let spread = half.sin2 / alpha2 + half.cos2;
    FRAC_1_PI / (alpha2 * spread * spread)
}

/// Smith's masking of one direction (Walter et al. 2007, eq. 34).
#[inline(always)]
pub(crate) fn smith(cosine: f32, alpha: f32) -> f32 {
    let cos2 = cosine * cosine;
    let tan2 = (1.0 - cos2).max(0.0) / cos2;
    2.0 / (1.0 + (1.0 + alpha * alpha * tan2).sqrt())
}
