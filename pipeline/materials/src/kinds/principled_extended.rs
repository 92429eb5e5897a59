//! The principled material with a coat and with transmission: Mitsuba 3's `principled` with base
//! colour, roughness, metallic, clearcoat, clearcoat_gloss, spec_trans and eta.
//!
//! Own numbers: clearcoat, clearcoat gloss, transmission, index of refraction. From within only the
//! main lobe is seen.

use super::lambert::{cosine_hemisphere, cosine_hemisphere_pdf};
use super::principled::burley;
use super::rough_dielectric::{rough_density, rough_value};
use crate::fresnel::{dielectric, schlick};
use crate::ggx::{Half, alpha, ggx, smith, visible_normal, visible_normal_density};
use crate::kind::scatter_lanes;
use crate::math::{pick, sin_cos_turn};
use crate::opaque;
use crate::refraction::{mirrored, refracted};
use crate::{
    Bsdf, INVALID, Lobe, Material, MaterialKind, Parameter, Parts, Scatter, ShadingFrame, Slot,
    Storage,
};
use glam::Vec3;
use std::f32::consts::PI;

/// Mitsuba 3's `principled` with a coat and with transmission.
pub static PRINCIPLED_EXTENDED: MaterialKind = MaterialKind {
    name: "principled-extended",
    number: 7,
    slots: &[
        Slot::new("base colour", "base_color", Storage::BaseColor),
        Slot::new("roughness", "roughness", Storage::Roughness),
        Slot::new("metallic", "metallic", Storage::Metallic),
        Slot::new(
            "clearcoat",
            "clearcoat",
            Storage::Own { first: 0, width: 1 },
        ),
        Slot::new(
            "clearcoat gloss",
            "clearcoat_gloss",
            Storage::Own { first: 1, width: 1 },
        ),
        Slot::new(
            "transmission",
            "spec_trans",
            Storage::Own { first: 2, width: 1 },
        ),
        Slot::new(
            "index of refraction",
            "eta",
            Storage::Own { first: 3, width: 1 },
        ),
        Slot::new("absorption", "", Storage::Own { first: 4, width: 3 }),
    ],
    mitsuba: "principled",
    depends_on_viewer: true,
    is_black: |_| false,
    transmits: true,
    index: |bsdf| bsdf.own[3],
    interior: |bsdf| {
        let absorption = Vec3::new(bsdf.own[4], bsdf.own[5], bsdf.own[6]);
        (bsdf.own[2] > 0.0).then_some(absorption)
    },
    straight: opaque::straight,
    lobe: |bsdf| {
        let metal = bsdf.base_color.max_element() * bsdf.metallic;
        Some(Lobe {
            alpha: alpha(bsdf.roughness),
            reflectance: metal + (1.0 - bsdf.metallic) * dielectric(1.0, bsdf.eta),
        })
    },
    parts: |bsdf| {
        let [_, _, diffuse, coat] = shares(bsdf);
        let main = Parts::of_lobe(alpha(bsdf.roughness));
        let body = if diffuse > 0.0 && bsdf.base_color != Vec3::ZERO {
            Parts::BROAD
        } else {
            Parts::NONE
        };
        let coat = if coat > 0.0 {
            Parts::of_lobe(coat_alpha(bsdf))
        } else {
            Parts::NONE
        };
        main | body | coat
    },
    eval,
    pdf,
    sample,
    eval_lanes,
    sample_lanes,
};

scatter_lanes!(PRINCIPLED_EXTENDED);

/// Numbers of a principled material with a coat and with transmission.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layers {
    /// Strength of the coat in [0, 1].
    pub clearcoat: f32,
    /// Its gloss in [0, 1]: alpha falls from 0.1 to 0.001.
    pub clearcoat_gloss: f32,
    /// Share of light that is transmitted in place of diffuse reflection.
    pub transmission: f32,
    /// Index of refraction.
    pub ior: f32,
    /// Absorption inside [1/m].
    pub absorption: Vec3,
}

impl Material {
    /// The principled material with a coat and with transmission, without textures.
    pub fn principled_extended(
        name: impl Into<String>,
        base_color: Vec3,
        roughness: f32,
        metallic: f32,
        layers: Layers,
    ) -> Self {
        let own = |value| Parameter {
            value,
            texture: INVALID,
        };
        let ratio = (layers.ior - 1.0) / (layers.ior + 1.0);
        let number = |value| own(Vec3::splat(value));
        Self {
            kind: &PRINCIPLED_EXTENDED,
            roughness,
            metallic,
            specular: (ratio * ratio / 0.08).min(1.0),
            own: vec![
                number(layers.clearcoat),
                number(layers.clearcoat_gloss),
                number(layers.transmission),
                number(layers.ior),
                own(layers.absorption),
            ],
            ..Self::lambert(name, base_color)
        }
    }
}

/// GTR1 alpha of the coat.
#[inline(always)]
fn coat_alpha(bsdf: &Bsdf) -> f32 {
    0.1 + (0.001 - 0.1) * bsdf.own[1]
}

/// Transmission, main reflection's bound, diffuse share and a quarter of the coat, each as the viewer's
/// side sees them.
#[inline(always)]
fn shares(bsdf: &Bsdf) -> [f32; 4] {
    let dielectric = 1.0 - bsdf.metallic;
    let transmission = dielectric * bsdf.own[2];
    if bsdf.inside {
        [transmission, 1.0, 0.0, 0.0]
    } else {
        let diffuse = dielectric * (1.0 - bsdf.own[2]);
        [transmission, 1.0, diffuse, 0.25 * bsdf.own[0]]
    }
}

/// f |cos(theta_l)|.
#[inline(always)]
fn eval(bsdf: &Bsdf, n: Vec3, v: Vec3, l: Vec3) -> Vec3 {
    let (cos_v, cos_l) = (n.dot(v), n.dot(l));
    let [transmission, _, diffuse, coat] = shares(bsdf);
    let (alpha, coat_alpha) = (alpha(bsdf.roughness), coat_alpha(bsdf));
    let half = Half::new(n, v, l);
    let weight = schlick(half.cos_d);
    let glass = dielectric(half.cos_d, bsdf.eta);
    let metal = bsdf.base_color + (Vec3::ONE - bsdf.base_color) * weight;
    let front = Vec3::splat((1.0 - bsdf.metallic) * glass) + metal * bsdf.metallic;
    let fresnel = pick(bsdf.inside, Vec3::splat(transmission * glass), front);
    let lobe = ggx(&half, alpha) * smith(cos_v, alpha) * smith(cos_l, alpha) / (4.0 * cos_v);
    let body = diffuse * burley(bsdf.roughness, cos_v, cos_l, half.cos_d) * cos_l;
    let masking = smith(cos_v, 0.25) * smith(cos_l, 0.25);
    let schlick_coat = 0.04 + 0.96 * weight;
    let coat = coat * schlick_coat * gtr1(&half, coat_alpha) * masking * cos_l;
    let parts = bsdf.parts;
    let above = fresnel * lobe * parts.lobe(alpha)
        + bsdf.base_color * body * parts.broad()
        + Vec3::splat(coat * parts.lobe(coat_alpha));
    let [_, refracted] = rough_value(bsdf.eta, alpha, n, v, l);
    let tint = bsdf.base_color.max(Vec3::ZERO).map(f32::sqrt);
    let below = tint * (transmission * refracted * parts.lobe(alpha));
    let value = pick(cos_l > 0.0, above, below);
    pick((cos_v > 0.0) & (cos_l != 0.0), value, Vec3::ZERO)
}

/// GTR1 density of microfacet normals \[1/sr\] (Burley 2012).
#[inline(always)]
fn gtr1(half: &Half, alpha: f32) -> f32 {
    let alpha2 = alpha * alpha;
    // 1 + (alpha² - 1) cos² by sine and cosine, which keeps a narrow lobe's digits
    let spread = half.sin2 + alpha2 * half.cos2;
    (alpha2 - 1.0) / (PI * alpha2.ln() * spread)
}

/// A microfacet normal of that density times its cosine.
#[inline(always)]
fn gtr1_normal(alpha: f32, u: [f32; 2]) -> Vec3 {
    let alpha2 = alpha * alpha;
    let cos2 = ((1.0 - alpha2.powf(1.0 - u[1])) / (1.0 - alpha2)).clamp(0.0, 1.0);
    let (sine, cosine) = sin_cos_turn(u[0]);
    let radius = (1.0 - cos2).sqrt();
    Vec3::new(radius * cosine, radius * sine, cos2.sqrt())
}

/// How often [`sample`] takes the body, the coat, the main lobe.
#[inline(always)]
fn choices(bsdf: &Bsdf) -> [f32; 3] {
    let [_, main, diffuse, coat] = shares(bsdf);
    let main = main * bsdf.parts.lobe(alpha(bsdf.roughness));
    let diffuse = diffuse * bsdf.parts.broad();
    let coat = coat * bsdf.parts.lobe(coat_alpha(bsdf));
    let sum = (main + diffuse + coat).max(f32::MIN_POSITIVE);
    [diffuse / sum, coat / sum, main / sum]
}

/// Share of microfacets of the main lobe that refract, by Fresnel's reflectance at them.
#[inline(always)]
fn refracting(bsdf: &Bsdf, fresnel: f32) -> f32 {
    let [transmission, ..] = shares(bsdf);
    let share = if bsdf.inside { 1.0 } else { transmission };
    share * (1.0 - fresnel)
}

/// A direction: the first number chooses the lobe, the others the direction in it.
#[inline(always)]
fn sample(bsdf: &Bsdf, n: Vec3, v: Vec3, u: [f32; 3]) -> Scatter {
    let frame = ShadingFrame::new(n);
    let local = frame.to_local(v);
    let [diffuse, coat, main] = choices(bsdf);
    let h = visible_normal(local, alpha(bsdf.roughness), [u[1], u[2]]);
    let fresnel = dielectric(h.dot(local).max(f32::MIN_POSITIVE), bsdf.eta);
    let through = main * refracting(bsdf, fresnel);
    let coated = mirrored(local, gtr1_normal(coat_alpha(bsdf), [u[1], u[2]]));
    let takes_body = u[0] < diffuse;
    let takes_coat = !takes_body & (u[0] < diffuse + coat);
    let refracts = !takes_body & !takes_coat & (u[0] < diffuse + coat + through);
    let facet = pick(refracts, refracted(local, h, bsdf.eta), mirrored(local, h));
    let l = pick(takes_coat, coated, facet);
    let l = pick(takes_body, cosine_hemisphere([u[1], u[2]]), l);
    let l = frame.to_world(l);
    // a microfacet may send light to the wrong side of the surface
    let pdf = if refracts == (n.dot(l) < 0.0) {
        pdf(bsdf, n, v, l)
    } else {
        0.0
    };
    Scatter::weighted(l, eval(bsdf, n, v, l), pdf)
}

/// Density of [`sample`].
#[inline(always)]
fn pdf(bsdf: &Bsdf, n: Vec3, v: Vec3, l: Vec3) -> f32 {
    let (cos_v, cos_l) = (n.dot(v), n.dot(l));
    let [diffuse, coat, main] = choices(bsdf);
    let alpha = alpha(bsdf.roughness);
    let half = Half::new(n, v, l);
    let jacobian = 1.0 / (4.0 * half.cos_d);
    let reflecting = 1.0 - refracting(bsdf, dielectric(half.cos_d, bsdf.eta));
    let facet = main * reflecting * visible_normal_density(&half, cos_v, alpha) * jacobian;
    let coated = coat * gtr1(&half, coat_alpha(bsdf)) * half.cos2.sqrt() * jacobian;
    let above = facet + coated + diffuse * cosine_hemisphere_pdf(cos_l);
    let [_, crossing] = rough_density(bsdf.eta, alpha, n, v, l);
    let below = main * refracting(bsdf, 0.0) * crossing;
    if (cos_v > 0.0) & (cos_l > 0.0) {
        above
    } else if (cos_v > 0.0) & (cos_l < 0.0) {
        below
    } else {
        0.0
    }
}
