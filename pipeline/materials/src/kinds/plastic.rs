//! Plastic: a diffuse body under a rough dielectric coat, as in Mitsuba 3's `roughplastic`.
//!
//! Light that the coat sends back to the body is coloured by it once more. Nonlinear plastic counts
//! that, as a real coat does and pbrt's `coateddiffuse`. Linear plastic, Mitsuba's default, takes
//! the body for white there, so that its colour is the one that is stated.
//!
//! Own numbers: index of refraction of the coat, and 1 for nonlinear or 0 for linear plastic.

use super::lambert::{cosine_hemisphere, cosine_hemisphere_pdf};
use super::plastic_table::{internal_reflectance, transmittance};
use crate::fresnel::dielectric;
use crate::ggx::{Half, alpha, ggx, smith, visible_normal, visible_normal_density};
use crate::kind::scatter_lanes;
use crate::math::pick;
use crate::opaque;
use crate::refraction::mirrored;
use crate::{
    Bsdf, Lobe, Material, MaterialKind, Parameter, Parts, Scatter, ShadingFrame, Slot, Storage,
};
use glam::Vec3;
use std::f32::consts::FRAC_1_PI;

/// A diffuse body under a coat.
pub static PLASTIC: MaterialKind = MaterialKind {
    name: "plastic",
    number: 3,
    slots: &[
        Slot::new("base colour", "diffuse_reflectance", Storage::BaseColor),
        Slot::new("roughness", "alpha", Storage::Roughness),
        Slot::new(
            "index of refraction",
            "int_ior",
            Storage::Own { first: 0, width: 1 },
        ),
        Slot::new(
            "nonlinear",
            "nonlinear",
            Storage::Own { first: 1, width: 1 },
        ),
    ],
    mitsuba: "roughplastic",
    depends_on_viewer: true,
    is_black: |_| false,
    transmits: false,
    index: |bsdf| bsdf.own[0],
    interior: opaque::interior,
    straight: opaque::straight,
    lobe: |bsdf| {
        Some(Lobe {
            alpha: alpha(bsdf.roughness),
            reflectance: dielectric(1.0, bsdf.eta),
        })
    },
    parts: |bsdf| {
        let coat = Parts::of_lobe(alpha(bsdf.roughness));
        if bsdf.base_color == Vec3::ZERO {
            coat
        } else {
            coat | Parts::BROAD
        }
    },
    eval,
    pdf,
    sample,
    eval_lanes,
    sample_lanes,
};

scatter_lanes!(PLASTIC);

impl Material {
    /// Linear plastic without textures.
    pub fn plastic(name: impl Into<String>, base_color: Vec3, roughness: f32, ior: f32) -> Self {
        let ratio = (ior - 1.0) / (ior + 1.0);
        Self {
            kind: &PLASTIC,
            roughness,
            specular: (ratio * ratio / 0.08).min(1.0),
            own: [ior, 0.0].map(Parameter::number).to_vec(),
            ..Self::lambert(name, base_color)
        }
    }

    /// Nonlinear plastic without textures.
    pub fn nonlinear_plastic(
        name: impl Into<String>,
        base_color: Vec3,
        roughness: f32,
        ior: f32,
    ) -> Self {
        Self {
            own: [ior, 1.0].map(Parameter::number).to_vec(),
            ..Self::plastic(name, base_color, roughness, ior)
        }
    }
}

/// f cos(theta_l). What enters and leaves through the coat is scaled by its transmittance both
/// times; what it sends back inside adds up as a geometric series.
#[inline(always)]
fn eval(bsdf: &Bsdf, n: Vec3, v: Vec3, l: Vec3) -> Vec3 {
    let (cos_v, cos_l) = (n.dot(v), n.dot(l));
    let (eta, alpha) = (bsdf.eta, alpha(bsdf.roughness));
    let half = Half::new(n, v, l);
    let lobe = ggx(&half, alpha) * smith(cos_v, alpha) * smith(cos_l, alpha) / (4.0 * cos_v);
    let coat = dielectric(half.cos_d, eta) * lobe * bsdf.parts.lobe(alpha);
    let through = transmittance(cos_v, alpha, eta) * transmittance(cos_l, alpha, eta);
    let [linear, nonlinear] = internal_reflectance(alpha, eta);
    let part = bsdf.own[1];
    let again = Vec3::splat(linear * (1.0 - part)) + bsdf.base_color * (nonlinear * part);
    let series = Vec3::ONE - again;
    let body = through * cos_l * FRAC_1_PI * bsdf.parts.broad() / (eta * eta);
    let value = Vec3::splat(coat) + bsdf.base_color * body / series;
    pick((cos_v > 0.0) & (cos_l > 0.0), value, Vec3::ZERO)
}

/// How often [`sample`] takes the coat.
#[inline(always)]
fn coat_probability(bsdf: &Bsdf, cos_v: f32) -> f32 {
    let alpha = alpha(bsdf.roughness);
    let through = transmittance(cos_v, alpha, bsdf.eta);
    let weight = 1.0 / (1.0 + bsdf.base_color.element_sum() / 3.0);
    let coat = (1.0 - through) * weight * bsdf.parts.lobe(alpha);
    let body = through * (1.0 - weight) * bsdf.parts.broad();
    coat / (coat + body).max(f32::MIN_POSITIVE)
}

/// A direction: the first number chooses coat or body, the others the direction.
#[inline(always)]
fn sample(bsdf: &Bsdf, n: Vec3, v: Vec3, u: [f32; 3]) -> Scatter {
    let frame = ShadingFrame::new(n);
    let local = frame.to_local(v);
    let h = visible_normal(local, alpha(bsdf.roughness), [u[1], u[2]]);
    let diffuse = cosine_hemisphere([u[1], u[2]]);
    let takes_coat = u[0] < coat_probability(bsdf, local.z);
    let l = frame.to_world(pick(takes_coat, mirrored(local, h), diffuse));
    let pdf = pdf(bsdf, n, v, l);
    Scatter::weighted(l, eval(bsdf, n, v, l), pdf)
}

/// Density of [`sample`].
#[inline(always)]
fn pdf(bsdf: &Bsdf, n: Vec3, v: Vec3, l: Vec3) -> f32 {
    let (cos_v, cos_l) = (n.dot(v), n.dot(l));
    let half = Half::new(n, v, l);
    let coat = visible_normal_density(&half, cos_v, alpha(bsdf.roughness)) / (4.0 * half.cos_d);
    let choice = coat_probability(bsdf, cos_v);
    if (cos_v > 0.0) & (cos_l > 0.0) {
        choice * coat + (1.0 - choice) * cosine_hemisphere_pdf(cos_l)
    } else {
        0.0
    }
}
