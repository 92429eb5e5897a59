//! Microfacets that light is refracted by (Walter et al. 2007).

use crate::ggx::Half;
use glam::Vec3;

/// Two directions on the two sides of a surface, by the microfacet that refracts one into the other.
pub(crate) struct Crossing {
    pub(crate) half: Half,
    /// v.h and -l.h, both positive where the crossing is possible.
    cos_v: f32,
    cos_l: f32,
    /// v.h + eta l.h
    spread: f32,
}

impl Crossing {
    /// `eta` is the index of refraction on the side of `l` over that on the side of `v`.
    #[inline(always)]
    pub(crate) fn new(n: Vec3, v: Vec3, l: Vec3, eta: f32) -> Crossing {
        let sum = v + l * eta;
        let sum = if n.dot(sum) < 0.0 { -sum } else { sum };
        let h = sum / sum.length().max(f32::MIN_POSITIVE);
        let (cos_v, cos_l) = (v.dot(h), -l.dot(h));
        Crossing {
            half: Half::along(n, v, sum),
            cos_v,
            cos_l,
            spread: cos_v - eta * cos_l,
        }
    }

    /// Whether a microfacet refracts one into the other.
    #[inline(always)]
    pub(crate) fn is_possible(&self) -> bool {
        (self.cos_v > 0.0) & (self.cos_l > 0.0) & (self.spread != 0.0)
    }

    /// v.h |l.h| / (v.h + eta l.h)², the factor of the lobe's value.
    #[inline(always)]
    pub(crate) fn factor(&self) -> f32 {
        self.cos_v * self.cos_l / (self.spread * self.spread)
    }

    /// Solid angle of h over that of l (Walter et al. 2007, eq. 17).
    #[inline(always)]
    pub(crate) fn jacobian(&self, eta: f32) -> f32 {
        eta * eta * self.cos_l / (self.spread * self.spread)
    }
}

/// `v` mirrored at a microfacet.
#[inline(always)]
pub(crate) fn mirrored(v: Vec3, h: Vec3) -> Vec3 {
    h * (2.0 * h.dot(v)) - v
}

/// `v` refracted by a microfacet, v.h > 0, into the index of refraction `eta` times that on its side;
/// along the surface where all is reflected.
#[inline(always)]
pub(crate) fn refracted(v: Vec3, h: Vec3, eta: f32) -> Vec3 {
    let (inverse, cosine) = (1.0 / eta, v.dot(h));
    let inside = (1.0 - inverse * inverse * (1.0 - cosine * cosine)).max(0.0);
    (h * (inverse * cosine - inside.sqrt()) - v * inverse).normalize()
}
