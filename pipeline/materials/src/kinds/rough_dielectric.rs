//! Frosted glass: reflection and refraction by GGX microfacets, as in Mitsuba 3's `roughdielectric`
//! (Walter et al. 2007), with absorption inside.

use super::dielectric::{index, interior, is_black, reflectance};
use crate::fresnel::dielectric;
use crate::ggx::{Half, alpha, ggx, smith, visible_normal, visible_normal_density};
use crate::kind::scatter_lanes;
use crate::math::pick;
use crate::opaque;
use crate::refraction::{Crossing, mirrored, refracted};
use crate::{Bsdf, Lobe, Material, MaterialKind, Parts, Scatter, ShadingFrame, Slot, Storage};
use glam::Vec3;

/// Frosted glass; its own numbers are those of clear glass.
pub static ROUGH_DIELECTRIC: MaterialKind = MaterialKind {
    name: "rough-dielectric",
    number: 5,
    slots: &[
        Slot::new("base colour", "specular_transmittance", Storage::BaseColor),
        Slot::new("roughness", "alpha", Storage::Roughness),
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
    ],
    mitsuba: "roughdielectric",
    depends_on_viewer: true,
    is_black,
    transmits: true,
    index,
    interior,
    straight: opaque::straight,
    lobe: |bsdf| {
        Some(Lobe {
            alpha: alpha(bsdf.roughness),
            reflectance: dielectric(1.0, bsdf.own[0]),
        })
    },
    parts: |bsdf| Parts::of_lobe(alpha(bsdf.roughness)),
    eval,
    pdf,
    sample,
    eval_lanes,
    sample_lanes,
};

scatter_lanes!(ROUGH_DIELECTRIC);

impl Material {
    /// Frosted glass without textures. An index within 0.001 of 1 would refract nothing, and makes it
    /// clear glass.
    pub fn rough_dielectric(
        name: impl Into<String>,
        ior: f32,
        tint: Vec3,
        absorption: Vec3,
        roughness: f32,
    ) -> Self {
        let clear = Self::dielectric(name, ior, tint, absorption);
        if (ior - 1.0).abs() < 1e-3 {
            return clear;
        }
        Self {
            kind: &ROUGH_DIELECTRIC,
            roughness,
            ..clear
        }
    }
}

/// Value of reflection and refraction by microfacets, without colours: f |cos(theta_l)|.
#[inline(always)]
pub(super) fn rough_value(eta: f32, alpha: f32, n: Vec3, v: Vec3, l: Vec3) -> [f32; 2] {
    let (cos_v, cos_l) = (n.dot(v), n.dot(l));
    let shadowing = smith(cos_v, alpha) * smith(cos_l, alpha) / cos_v;
    let half = Half::new(n, v, l);
    let reflected = dielectric(half.cos_d, eta) * ggx(&half, alpha) * shadowing / 4.0;
    let crossing = Crossing::new(n, v, l, eta);
    let share = 1.0 - dielectric(crossing.half.cos_d, eta);
    // the factor eta² of the lobe and 1 / eta² of radiance cancel
    let refracted = share * ggx(&crossing.half, alpha) * shadowing * crossing.factor();
    let above = (cos_v > 0.0) & (cos_l > 0.0);
    let below = (cos_v > 0.0) & (cos_l < 0.0) & crossing.is_possible();
    [
        if above { reflected } else { 0.0 },
        if below { refracted } else { 0.0 },
    ]
}

/// Density of choosing a visible microfacet, and Fresnel's share of reflection or refraction by it;
/// then these shares.
#[inline(always)]
pub(super) fn rough_density(eta: f32, alpha: f32, n: Vec3, v: Vec3, l: Vec3) -> [f32; 2] {
    let (cos_v, cos_l) = (n.dot(v), n.dot(l));
    let half = Half::new(n, v, l);
    let mirror = visible_normal_density(&half, cos_v, alpha) / (4.0 * half.cos_d);
    let crossing = Crossing::new(n, v, l, eta);
    let normal = visible_normal_density(&crossing.half, cos_v, alpha);
    let share = 1.0 - dielectric(crossing.half.cos_d, eta);
    let above = (cos_v > 0.0) & (cos_l > 0.0);
    let below = (cos_v > 0.0) & (cos_l < 0.0) & crossing.is_possible();
    [
        if above {
            mirror * dielectric(half.cos_d, eta)
        } else {
            0.0
        },
        if below {
            normal * crossing.jacobian(eta) * share
        } else {
            0.0
        },
    ]
}

/// f |cos(theta_l)|.
#[inline(always)]
fn eval(bsdf: &Bsdf, n: Vec3, v: Vec3, l: Vec3) -> Vec3 {
    let alpha = alpha(bsdf.roughness);
    let [above, below] = rough_value(bsdf.eta, alpha, n, v, l);
    (reflectance(bsdf) * above + bsdf.base_color * below) * bsdf.parts.lobe(alpha)
}

/// A microfacet by the last two of three numbers; it reflects or refracts by the first one.
#[inline(always)]
fn sample(bsdf: &Bsdf, n: Vec3, v: Vec3, u: [f32; 3]) -> Scatter {
    let frame = ShadingFrame::new(n);
    let local = frame.to_local(v);
    let h = visible_normal(local, alpha(bsdf.roughness), [u[1], u[2]]);
    let reflects = u[0] < dielectric(h.dot(local).max(f32::MIN_POSITIVE), bsdf.eta);
    let l = pick(reflects, mirrored(local, h), refracted(local, h, bsdf.eta));
    let l = frame.to_world(l);
    // a microfacet may send light to the wrong side of the surface
    let pdf = if reflects == (n.dot(l) > 0.0) {
        pdf(bsdf, n, v, l)
    } else {
        0.0
    };
    Scatter::weighted(l, eval(bsdf, n, v, l), pdf)
}

/// Density of [`sample`].
#[inline(always)]
fn pdf(bsdf: &Bsdf, n: Vec3, v: Vec3, l: Vec3) -> f32 {
    let [above, below] = rough_density(bsdf.eta, alpha(bsdf.roughness), n, v, l);
    above + below
}
