//! Fresnel terms.

use glam::Vec3;

/// (1 - cos)^5.
#[inline(always)]
pub(crate) fn schlick(cosine: f32) -> f32 {
    let x = (1.0 - cosine).clamp(0.0, 1.0);
    let x2 = x * x;
    x2 * x2 * x
}

/// Index of refraction of a `specular` parameter: 0.5 means 1.5.
#[inline(always)]
pub(crate) fn index_of_refraction(specular: f32) -> f32 {
    2.0 / (1.0 - (0.08 * specular).sqrt()) - 1.0
}

/// Unpolarised Fresnel reflectance of a dielectric whose index of refraction is `eta` times that on
/// the viewer's side; 1 where all is reflected.
#[inline(always)]
pub(crate) fn dielectric(cosine: f32, eta: f32) -> f32 {
    let inside = (1.0 - (1.0 - cosine * cosine) / (eta * eta))
        .max(0.0)
        .sqrt();
    let s = (cosine - eta * inside) / (cosine + eta * inside);
    let p = (inside - eta * cosine) / (inside + eta * cosine);
    0.5 * (s * s + p * p)
}

/// Unpolarised Fresnel reflectance of a conductor with index eta + ik, a channel each.
#[inline(always)]
pub(crate) fn conductor(cosine: f32, eta: Vec3, k: Vec3) -> Vec3 {
    let cos2 = cosine * cosine;
    let sin2 = 1.0 - cos2;
    let (eta2, k2) = (eta * eta, k * k);
    let t = eta2 - k2 - Vec3::splat(sin2);
    // a² + b² and a of the refracted wave, by Born and Wolf's a + ib
    let sum = root(t * t + 4.0 * eta2 * k2);
    let a = root((sum + t) * 0.5);
    let (s1, s2) = (sum + Vec3::splat(cos2), a * (2.0 * cosine));
    let s = (s1 - s2) / (s1 + s2);
    let (p1, p2) = (sum * cos2 + Vec3::splat(sin2 * sin2), s2 * sin2);
    let p = s * (p1 - p2) / (p1 + p2);
    (s + p) * 0.5
}

#[inline(always)]
fn root(v: Vec3) -> Vec3 {
    let v = v.max(Vec3::ZERO);
    Vec3::new(v.x.sqrt(), v.y.sqrt(), v.z.sqrt())
}
