//! The principled material with base colour, roughness, metallic and specular: exactly the
//! values of Mitsuba 3's `principled` with those four parameters.
//!
//! Specular: GGX with alpha = max(0.001, roughness^2), separable Smith masking (Walter et al.
//! 2007); its Fresnel factor is (1 - metallic) times the exact dielectric one plus metallic times
//! Schlick's with the base colour. Diffuse: Burley 2012 times (1 - metallic), not scaled by
//! what the specular lobe takes. Both lobes are reciprocal.

use super::lambert::{cosine_hemisphere, cosine_hemisphere_pdf};
use super::{Bsdf, Scatter};
use crate::math::{pick, sin_cos_turn};
use crate::surface::Frame;
use glam::Vec3;
use std::f32::consts::{FRAC_1_PI, PI};

/// Smallest GGX alpha.
const ALPHA_MIN: f32 = 0.001;
/// Normal-incidence reflectance that the lobe choice gives the dielectric lobe at least: its
/// grazing half vectors reflect far more than the view angle suggests.
const CHOICE_MIN: f32 = 0.1;

/// f cos(theta_l).
#[inline(always)]
pub fn eval(bsdf: &Bsdf, n: Vec3, v: Vec3, l: Vec3) -> Vec3 {
    let (cos_v, cos_l) = (n.dot(v), n.dot(l));
    let half = Half::new(n, v, l);
    let alpha = alpha(bsdf.roughness);
    let schlick = schlick(half.cos_d);
    let metal = bsdf.base_color + (Vec3::ONE - bsdf.base_color) * schlick;
    let glass = dielectric(half.cos_d, index_of_refraction(bsdf.specular));
    let fresnel = Vec3::splat((1.0 - bsdf.metallic) * glass) + metal * bsdf.metallic;
    let specular = ggx(&half, alpha) * smith(cos_v, alpha) * smith(cos_l, alpha) / (4.0 * cos_v);
    let diffuse = (1.0 - bsdf.metallic) * burley(bsdf.roughness, cos_v, cos_l, half.cos_d) * cos_l;
    let value = fresnel * specular + bsdf.base_color * diffuse;
    pick((cos_v > 0.0) & (cos_l > 0.0), value, Vec3::ZERO)
}

/// A direction: the first number chooses the lobe, the others the direction in it.
#[inline(always)]
pub fn sample(bsdf: &Bsdf, n: Vec3, v: Vec3, u: [f32; 3]) -> Scatter {
    let frame = Frame::new(n);
    let local = frame.to_local(v);
    let h = visible_normal(local, alpha(bsdf.roughness), [u[1], u[2]]);
    let mirrored = h * (2.0 * h.dot(local)) - local;
    let diffuse = cosine_hemisphere([u[1], u[2]]);
    let choice = specular_probability(bsdf, local.z);
    let l = frame.to_world(pick(u[0] < choice, mirrored, diffuse));
    let pdf = pdf(bsdf, n, v, l);
    let weight = eval(bsdf, n, v, l) / pdf;
    Scatter {
        l,
        weight: pick(pdf > 0.0, weight, Vec3::ZERO),
        pdf,
    }
}

/// Density of [`sample`].
#[inline(always)]
pub fn pdf(bsdf: &Bsdf, n: Vec3, v: Vec3, l: Vec3) -> f32 {
    let (cos_v, cos_l) = (n.dot(v), n.dot(l));
    let half = Half::new(n, v, l);
    let alpha = alpha(bsdf.roughness);
    let choice = specular_probability(bsdf, cos_v);
    // The reflection's Jacobian is 1 / (4 v.h) (Walter et al. 2007, eq. 14).
    let specular = visible_normal_density(&half, cos_v, alpha) / (4.0 * half.cos_d);
    let diffuse = cosine_hemisphere_pdf(cos_l);
    let density = choice * specular + (1.0 - choice) * diffuse;
    if (cos_v > 0.0) & (cos_l > 0.0) {
        density
    } else {
        0.0
    }
}

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
fn visible_normal_density(half: &Half, cos_v: f32, alpha: f32) -> f32 {
    smith(cos_v, alpha) * half.cos_d * ggx(half, alpha) / cos_v
}

/// How often [`sample`] takes the specular lobe.
#[inline(always)]
fn specular_probability(bsdf: &Bsdf, cos_v: f32) -> f32 {
    let base = luminance(bsdf.base_color);
    let glass = dielectric(cos_v, index_of_refraction(bsdf.specular)).max(CHOICE_MIN);
    let metal = base + (1.0 - base) * schlick(cos_v);
    let specular = (1.0 - bsdf.metallic) * glass + bsdf.metallic * metal.max(CHOICE_MIN);
    specular / (specular + (1.0 - bsdf.metallic) * base)
}

/// The half vector h of v and l by what the lobes need of it.
struct Half {
    /// sin^2 and cos^2 of its angle to the normal.
    sin2: f32,
    cos2: f32,
    /// v.h = l.h
    cos_d: f32,
}

impl Half {
    #[inline(always)]
    fn new(n: Vec3, v: Vec3, l: Vec3) -> Half {
        let sum = v + l;
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
fn ggx(half: &Half, alpha: f32) -> f32 {
    let alpha2 = alpha * alpha;
    let spread = half.sin2 / alpha2 + half.cos2;
    FRAC_1_PI / (alpha2 * spread * spread)
}

/// Smith's masking of one direction (Walter et al. 2007, eq. 34).
#[inline(always)]
fn smith(cosine: f32, alpha: f32) -> f32 {
    let cos2 = cosine * cosine;
    let tan2 = (1.0 - cos2).max(0.0) / cos2;
    2.0 / (1.0 + (1.0 + alpha * alpha * tan2).sqrt())
}

/// (1 - cos)^5.
#[inline(always)]
fn schlick(cosine: f32) -> f32 {
    let x = (1.0 - cosine).clamp(0.0, 1.0);
    let x2 = x * x;
    x2 * x2 * x
}

/// Index of refraction of a `specular` parameter: 0.5 means 1.5.
#[inline(always)]
fn index_of_refraction(specular: f32) -> f32 {
    2.0 / (1.0 - (0.08 * specular).sqrt()) - 1.0
}

/// Unpolarised Fresnel reflectance of a dielectric seen from outside.
#[inline(always)]
fn dielectric(cosine: f32, eta: f32) -> f32 {
    let inside = (1.0 - (1.0 - cosine * cosine) / (eta * eta))
        .max(0.0)
        .sqrt();
    let s = (cosine - eta * inside) / (cosine + eta * inside);
    let p = (inside - eta * cosine) / (inside + eta * cosine);
    0.5 * (s * s + p * p)
}

/// Burley's diffuse lobe without its colour (2012 course notes, section 5.3).
#[inline(always)]
fn burley(roughness: f32, cos_v: f32, cos_l: f32, cos_d: f32) -> f32 {
    let grazing = 2.0 * roughness * cos_d * cos_d - 0.5;
    (1.0 + grazing * schlick(cos_v)) * (1.0 + grazing * schlick(cos_l)) / PI
}

/// Luminance of a linear sRGB colour.
#[inline(always)]
fn luminance(color: Vec3) -> f32 {
    color.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}
