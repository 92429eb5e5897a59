//! A thin pane: reflection at both of its faces, and light that goes straight through, as in Mitsuba 3's
//! `thindielectric`.
//!
//! Own numbers: index of refraction, factor of the reflectance. The base colour is a factor of what
//! goes through.

use crate::fresnel::dielectric;
use crate::kind::scatter_lanes;
use crate::math::pick;
use crate::opaque;
use crate::refraction::mirrored;
use crate::{
    Bsdf, CERTAIN, INVALID, Material, MaterialKind, Parameter, Parts, Scatter, Slot, Storage,
};
use glam::Vec3;

/// A thin pane.
pub static THIN_DIELECTRIC: MaterialKind = MaterialKind {
    name: "thin-dielectric",
    number: 6,
    slots: &[
        Slot::new("base colour", "specular_transmittance", Storage::BaseColor),
        Slot::new(
            "index of refraction",
            "int_ior",
            Storage::Own { first: 0, width: 1 },
        ),
        Slot::new(
            "reflectance",
            "specular_reflectance",
            Storage::Own { first: 1, width: 3 },
        ),
    ],
    mitsuba: "thindielectric",
    depends_on_viewer: true,
    is_black: |bsdf| bsdf.base_color == Vec3::ZERO && reflectance(bsdf) == Vec3::ZERO,
    transmits: true,
    index: opaque::index,
    interior: opaque::interior,
    straight: |bsdf, cosine| bsdf.base_color * (1.0 - reflected(bsdf, cosine)),
    lobe: |_| None,
    parts: |_| Parts::NARROW,
    eval,
    pdf,
    sample,
    eval_lanes,
    sample_lanes,
};

scatter_lanes!(THIN_DIELECTRIC);

impl Material {
    /// A thin pane without textures; `tint` is a factor of what goes through it.
    pub fn thin_dielectric(name: impl Into<String>, ior: f32, tint: Vec3) -> Self {
        let own = |value| Parameter {
            value,
            texture: INVALID,
        };
        let ratio = (ior - 1.0) / (ior + 1.0);
        Self {
            kind: &THIN_DIELECTRIC,
            roughness: 0.0,
            specular: (ratio * ratio / 0.08).min(1.0),
            own: vec![own(Vec3::splat(ior)), own(Vec3::ONE)],
            ..Self::lambert(name, tint)
        }
    }
}

#[inline(always)]
fn reflectance(bsdf: &Bsdf) -> Vec3 {
    Vec3::new(bsdf.own[1], bsdf.own[2], bsdf.own[3])
}

/// Share that a pane reflects: r + t r t + t r³ t + ... = 2 r / (1 + r) of one face's r.
#[inline(always)]
fn reflected(bsdf: &Bsdf, cosine: f32) -> f32 {
    let once = dielectric(cosine.abs().max(f32::MIN_POSITIVE), bsdf.own[0]);
    2.0 * once / (1.0 + once)
}

/// Reflects with the probability of the pane's reflectance, by the first of three numbers, else goes
/// straight on; always reflects where light that goes straight through is left out.
#[inline(always)]
fn sample(bsdf: &Bsdf, n: Vec3, v: Vec3, u: [f32; 3]) -> Scatter {
    let cosine = n.dot(v);
    let share = reflected(bsdf, cosine);
    let straight = bsdf.parts.straight();
    let probability = share * straight + (1.0 - straight);
    let reflects = u[0] < probability;
    let back = reflectance(bsdf) * (share / probability.max(f32::MIN_POSITIVE));
    let counts = (cosine > 0.0) & (bsdf.parts.narrow() > 0.0);
    Scatter {
        l: pick(reflects, mirrored(v, n), -v),
        weight: pick(counts, pick(reflects, back, bsdf.base_color), Vec3::ZERO),
        pdf: if counts { CERTAIN } else { 0.0 },
    }
}

/// No value where a direction is given.
#[inline(always)]
fn eval(_: &Bsdf, _: Vec3, _: Vec3, _: Vec3) -> Vec3 {
    Vec3::ZERO
}

/// No density where a direction is given.
#[inline(always)]
fn pdf(_: &Bsdf, _: Vec3, _: Vec3, _: Vec3) -> f32 {
    0.0
}
