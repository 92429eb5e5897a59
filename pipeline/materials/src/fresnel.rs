//! Fresnel terms.

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

/// Unpolarised Fresnel reflectance of a dielectric seen from outside.
#[inline(always)]
pub(crate) fn dielectric(cosine: f32, eta: f32) -> f32 {
    let inside = (1.0 - (1.0 - cosine * cosine) / (eta * eta))
        .max(0.0)
        .sqrt();
    let s = (cosine - eta * inside) / (cosine + eta * inside);
    let p = (inside - eta * cosine) / (inside + eta * cosine);
    0.5 * (s * s + p * p)
}
