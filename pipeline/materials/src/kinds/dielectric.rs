//! Clear glass: sharp reflection and refraction, as in Mitsuba 3's `dielectric`, with absorption
//! inside (Beer and Lambert).
//!
//! Own numbers: index of refraction, absorption [1/m], factor of the reflectance. The base colour is a
//! factor of the transmittance at each crossing.

use crate::fresnel::dielectric;
use crate::kind::scatter_lanes;
use crate::math::pick;
use crate::opaque;
use crate::refraction::{mirrored, refracted};
use crate::{
    Bsdf, CERTAIN, INVALID, Material, MaterialKind, Parameter, Parts, Scatter, Slot, Storage,
};
use glam::Vec3;

/// Clear glass.
pub static DIELECTRIC: MaterialKind = MaterialKind {
    name: "dielectric",
    number: 4,
    slots: &GLASS,
    mitsuba: "dielectric",
    depends_on_viewer: true,
    is_black,
    transmits: true,
    index,
    interior,
    straight: opaque::straight,
    lobe: |_| None,
    parts: |_| Parts::NARROW,
    eval,
    pdf,
    sample,
    eval_lanes,
    sample_lanes,
};

scatter_lanes!(DIELECTRIC);

/// Parameters of smooth glass.
const GLASS: [Slot; 4] = [
    Slot::new("base colour", "specular_transmittance", Storage::BaseColor),
    Slot::new(
        "index of refraction",
        "int_ior",
        Storage::Own { first: 0, width: 1 },
    ),
    Slot::new("absorption", "", Storage::Own { first: 1, width: 3 }),
    Slot::new(
        "reflectance",
        "specular_reflectance",
        Storage::Own { first: 4, width: 3 },
    ),
];

impl Material {
    /// Clear glass without textures: `tint` is a factor of each crossing, `absorption` is in 1/m.
    pub fn dielectric(name: impl Into<String>, ior: f32, tint: Vec3, absorption: Vec3) -> Self {
        let own = |value| Parameter {
            value,
            texture: INVALID,
        };
        let ratio = (ior - 1.0) / (ior + 1.0);
        Self {
            kind: &DIELECTRIC,
            roughness: 0.0,
            specular: (ratio * ratio / 0.08).min(1.0),
            own: vec![own(Vec3::splat(ior)), own(absorption), own(Vec3::ONE)],
            ..Self::lambert(name, tint)
        }
    }
}

impl Bsdf {
    /// A surface that changes nothing: all light crosses it straight.
    pub const CLEAR: Bsdf = Bsdf {
        kind: &DIELECTRIC,
        base_color: Vec3::ONE,
        own: [1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.0],
        ..Bsdf::BLACK
    };
}

/// Index of refraction of a kind of glass.
pub(super) fn index(bsdf: &Bsdf) -> f32 {
    bsdf.own[0]
}

/// Absorption of a kind of glass.
pub(super) fn interior(bsdf: &Bsdf) -> Option<Vec3> {
    Some(Vec3::new(bsdf.own[1], bsdf.own[2], bsdf.own[3]))
}

/// Factor of the reflectance of a kind of glass.
#[inline(always)]
pub(super) fn reflectance(bsdf: &Bsdf) -> Vec3 {
    Vec3::new(bsdf.own[4], bsdf.own[5], bsdf.own[6])
}

/// Whether glass gives nothing at all.
pub(super) fn is_black(bsdf: &Bsdf) -> bool {
    bsdf.base_color == Vec3::ZERO && reflectance(bsdf) == Vec3::ZERO
}

/// Reflects with the probability of Fresnel's reflectance, by the first of three numbers, else
/// refracts. Radiance that goes into the denser side and is seen from the other is divided by the
/// square of the ratio of the indices.
#[inline(always)]
fn sample(bsdf: &Bsdf, n: Vec3, v: Vec3, u: [f32; 3]) -> Scatter {
    let cosine = n.dot(v);
    let fresnel = dielectric(cosine.max(f32::MIN_POSITIVE), bsdf.eta);
    let reflects = u[0] < fresnel;
    let l = pick(reflects, mirrored(v, n), refracted(v, n, bsdf.eta));
    let through = bsdf.base_color / (bsdf.eta * bsdf.eta);
    let counts = (cosine > 0.0) & (bsdf.parts.narrow() > 0.0);
    Scatter {
        l,
        weight: pick(
            counts,
            pick(reflects, reflectance(bsdf), through),
            Vec3::ZERO,
        ),
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
