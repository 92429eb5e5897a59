//! The principled material with base colour, roughness, metallic and specular: exactly the
//! values of Mitsuba 3's `principled` with those four parameters.
//!
//! Specular: GGX with alpha = max(0.001, roughness^2), separable Smith masking (Walter et al.
//! 2007); its Fresnel factor is (1 - metallic) times the exact dielectric one plus metallic times
//! Schlick's with the base colour. Diffuse: Burley 2012 times (1 - metallic), not scaled by
//! what the specular lobe takes. Both lobes are reciprocal.

use super::lambert::{cosine_hemisphere, cosine_hemisphere_pdf};
use crate::fresnel::{dielectric, index_of_refraction, schlick};
use crate::ggx::{Half, alpha, ggx, smith, visible_normal, visible_normal_density};
use crate::kind::scatter_lanes;
use crate::math::pick;
use crate::opaque;
use crate::{Bsdf, Lobe, Material, MaterialKind, Parts, Scatter, ShadingFrame, Slot, Storage};
use glam::Vec3;
use std::f32::consts::PI;

/// Mitsuba 3's `principled` with base colour, roughness, metallic and specular only.
pub static PRINCIPLED: MaterialKind = MaterialKind {
    name: "principled",
    number: 1,
    slots: &[
        Slot::new("base colour", "base_color", Storage::BaseColor),
        Slot::new("roughness", "roughness", Storage::Roughness),
        Slot::new("metallic", "metallic", Storage::Metallic),
        Slot::new("specular", "specular", Storage::Specular),
    ],
    mitsuba: "principled",
    depends_on_viewer: true,
    is_black: |_| false,
    transmits: false,
    index: opaque::index,
    interior: opaque::interior,
    straight: opaque::straight,
    lobe: |bsdf| {
        let metal = bsdf.base_color.max_element() * bsdf.metallic;
        Some(Lobe {
            alpha: alpha(bsdf.roughness),
            reflectance: metal + 0.08 * bsdf.specular * (1.0 - bsdf.metallic),
        })
    },
    parts: |bsdf| {
        let diffuse = luminance(bsdf.base_color) * (1.0 - bsdf.metallic) > 0.0;
        let specular = Parts::of_lobe(alpha(bsdf.roughness));
        if diffuse {
            specular | Parts::BROAD
        } else {
            specular
        }
    },
    eval,
    pdf,
    sample,
    eval_lanes,
    sample_lanes,
};

scatter_lanes!(PRINCIPLED);

impl Material {
    /// The principled material, without textures.
    pub fn principled(
        name: impl Into<String>,
        base_color: Vec3,
        roughness: f32,
        metallic: f32,
        specular: f32,
    ) -> Self {
        Self {
            kind: &PRINCIPLED,
            roughness,
            metallic,
            specular,
            ..Self::lambert(name, base_color)
        }
    }
}
/// Normal-incidence reflectance that the lobe choice gives the dielectric lobe at least: its
/// grazing half vectors reflect far more than the view angle suggests.
const CHOICE_MIN: f32 = 0.1;

/// f cos(theta_l).
#[inline(always)]
fn eval(bsdf: &Bsdf, n: Vec3, v: Vec3, l: Vec3) -> Vec3 {
    let (cos_v, cos_l) = (n.dot(v), n.dot(l));
    let half = Half::new(n, v, l);
    let alpha = alpha(bsdf.roughness);
    let schlick = schlick(half.cos_d);
    let metal = bsdf.base_color + (Vec3::ONE - bsdf.base_color) * schlick;
    let glass = dielectric(half.cos_d, index_of_refraction(bsdf.specular));
    let fresnel = Vec3::splat((1.0 - bsdf.metallic) * glass) + metal * bsdf.metallic;
    let specular = ggx(&half, alpha) * smith(cos_v, alpha) * smith(cos_l, alpha) / (4.0 * cos_v);
    let diffuse = (1.0 - bsdf.metallic) * burley(bsdf.roughness, cos_v, cos_l, half.cos_d) * cos_l;
    let (lobe, broad) = (bsdf.parts.lobe(alpha), bsdf.parts.broad());
    let value = fresnel * specular * lobe + bsdf.base_color * diffuse * broad;
    pick((cos_v > 0.0) & (cos_l > 0.0), value, Vec3::ZERO)
}

/// A direction: the first number chooses the lobe, the others the direction in it.
#[inline(always)]
fn sample(bsdf: &Bsdf, n: Vec3, v: Vec3, u: [f32; 3]) -> Scatter {
    let frame = ShadingFrame::new(n);
    let local = frame.to_local(v);
    let h = visible_normal(local, alpha(bsdf.roughness), [u[1], u[2]]);
    let mirrored = h * (2.0 * h.dot(local)) - local;
    let diffuse = cosine_hemisphere([u[1], u[2]]);
    let choice = specular_probability(bsdf, local.z);
    let l = frame.to_world(pick(u[0] < choice, mirrored, diffuse));
    let pdf = pdf(bsdf, n, v, l);
    Scatter::weighted(l, eval(bsdf, n, v, l), pdf)
}

/// Density of [`sample`].
#[inline(always)]
fn pdf(bsdf: &Bsdf, n: Vec3, v: Vec3, l: Vec3) -> f32 {
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

/// How often [`sample`] takes the specular lobe.
#[inline(always)]
fn specular_probability(bsdf: &Bsdf, cos_v: f32) -> f32 {
    let base = luminance(bsdf.base_color);
    let glass = dielectric(cos_v, index_of_refraction(bsdf.specular)).max(CHOICE_MIN);
    let metal = base + (1.0 - base) * schlick(cos_v);
    let specular = (1.0 - bsdf.metallic) * glass + bsdf.metallic * metal.max(CHOICE_MIN);
    let specular = specular * bsdf.parts.lobe(alpha(bsdf.roughness));
    specular / (specular + (1.0 - bsdf.metallic) * base * bsdf.parts.broad())
}

/// Burley's diffuse lobe without its colour (2012 course notes, section 5.3).
#[inline(always)]
pub(super) fn burley(roughness: f32, cos_v: f32, cos_l: f32, cos_d: f32) -> f32 {
    let grazing = 2.0 * roughness * cos_d * cos_d - 0.5;
    (1.0 + grazing * schlick(cos_v)) * (1.0 + grazing * schlick(cos_l)) / PI
}

/// Luminance of a linear sRGB colour.
#[inline(always)]
pub(super) fn luminance(color: Vec3) -> f32 {
    color.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}
