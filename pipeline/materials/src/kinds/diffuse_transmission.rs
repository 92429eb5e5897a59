//! Leaves and paper: ideal diffuse reflection and transmission, f = colour / pi on either side.
//!
//! Own numbers: transmittance.

use super::lambert::{cosine_hemisphere, cosine_hemisphere_pdf};
use super::principled::luminance;
use crate::kind::scatter_lanes;
use crate::math::pick;
use crate::opaque;
use crate::{
    Bsdf, INVALID, Material, MaterialKind, Parameter, Parts, Scatter, ShadingFrame, Slot, Storage,
};
use glam::Vec3;

/// Ideal diffuse reflection and transmission.
pub static DIFFUSE_TRANSMISSION: MaterialKind = MaterialKind {
    name: "diffuse-transmission",
    number: 8,
    slots: &[
        Slot::new("base colour", "reflectance", Storage::BaseColor),
        Slot::new("transmittance", "", Storage::Own { first: 0, width: 3 }),
    ],
    mitsuba: "diffuse",
    depends_on_viewer: false,
    is_black: |bsdf| bsdf.base_color == Vec3::ZERO && transmittance(bsdf) == Vec3::ZERO,
    transmits: true,
    index: opaque::index,
    interior: opaque::interior,
    straight: opaque::straight,
    lobe: |_| None,
    parts: |_| Parts::BROAD,
    eval,
    pdf,
    sample,
    eval_lanes,
    sample_lanes,
};

scatter_lanes!(DIFFUSE_TRANSMISSION);

impl Material {
    /// Ideal diffuse reflection and transmission, without textures.
    pub fn diffuse_transmission(
        name: impl Into<String>,
        reflectance: Vec3,
        transmittance: Vec3,
    ) -> Self {
        Self {
            kind: &DIFFUSE_TRANSMISSION,
            own: vec![Parameter {
                value: transmittance,
                texture: INVALID,
            }],
            ..Self::lambert(name, reflectance)
        }
    }
}

#[inline(always)]
fn transmittance(bsdf: &Bsdf) -> Vec3 {
    Vec3::new(bsdf.own[0], bsdf.own[1], bsdf.own[2])
}

/// How often [`sample`] reflects.
#[inline(always)]
fn reflection_probability(bsdf: &Bsdf) -> f32 {
    let (back, through) = (luminance(bsdf.base_color), luminance(transmittance(bsdf)));
    let sum = back + through;
    if sum > 0.0 { back / sum } else { 1.0 }
}

/// f |cos(theta_l)|.
#[inline(always)]
fn eval(bsdf: &Bsdf, n: Vec3, v: Vec3, l: Vec3) -> Vec3 {
    let cosine = n.dot(l);
    let value = pick(cosine > 0.0, bsdf.base_color, transmittance(bsdf));
    let value = value * cosine_hemisphere_pdf(cosine.abs()) * bsdf.parts.broad();
    pick(n.dot(v) > 0.0, value, Vec3::ZERO)
}

/// A side by the first of three numbers, a cosine-weighted direction by the others.
#[inline(always)]
fn sample(bsdf: &Bsdf, n: Vec3, v: Vec3, u: [f32; 3]) -> Scatter {
    let up = ShadingFrame::new(n).to_world(cosine_hemisphere([u[1], u[2]]));
    let below = u[0] >= reflection_probability(bsdf);
    let l = pick(below, up - n * (2.0 * n.dot(up)), up);
    let pdf = pdf(bsdf, n, v, l);
    Scatter::weighted(l, eval(bsdf, n, v, l), pdf)
}

/// Density of [`sample`].
#[inline(always)]
fn pdf(bsdf: &Bsdf, n: Vec3, v: Vec3, l: Vec3) -> f32 {
    let cosine = n.dot(l);
    let up = reflection_probability(bsdf);
    let side = if cosine > 0.0 { up } else { 1.0 - up };
    if n.dot(v) > 0.0 {
        side * cosine_hemisphere_pdf(cosine.abs())
    } else {
        0.0
    }
}
