//! Metals: GGX microfacets with the Fresnel reflectance of a complex index of refraction, as in
//! Mitsuba 3's `roughconductor`. Smooth metals have the smallest alpha, 0.001.

use crate::fresnel::conductor;
use crate::ggx::{Half, alpha, ggx, smith, visible_normal, visible_normal_density};
use crate::kind::scatter_lanes;
use crate::math::pick;
use crate::opaque;
use crate::refraction::mirrored;
use crate::{
    Bsdf, INVALID, Lobe, Material, MaterialKind, Parameter, Parts, Scatter, ShadingFrame, Slot,
    Storage,
};
use glam::Vec3;

/// Metal with eta and k; its base colour is a factor of the reflectance.
pub static CONDUCTOR: MaterialKind = MaterialKind {
    name: "conductor",
    number: 2,
    slots: &[
        Slot::new("base colour", "specular_reflectance", Storage::BaseColor),
        Slot::new("roughness", "alpha", Storage::Roughness),
        Slot::new("eta", "eta", Storage::Own { first: 0, width: 3 }),
        Slot::new("k", "k", Storage::Own { first: 3, width: 3 }),
    ],
    mitsuba: "roughconductor",
    depends_on_viewer: true,
    is_black: |bsdf| bsdf.base_color == Vec3::ZERO,
    transmits: false,
    index: opaque::index,
    interior: opaque::interior,
    straight: opaque::straight,
    lobe: |bsdf| {
        Some(Lobe {
            alpha: alpha(bsdf.roughness),
            reflectance: fresnel(bsdf, 1.0).max_element(),
        })
    },
    parts: |bsdf| Parts::of_lobe(alpha(bsdf.roughness)),
    eval,
    pdf,
    sample,
    eval_lanes,
    sample_lanes,
};

scatter_lanes!(CONDUCTOR);

/// Complex indices of refraction at red, green and blue.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metal {
    /// Real part.
    pub eta: Vec3,
    /// Imaginary part.
    pub k: Vec3,
}

impl Metal {
    /// Reflects all light at all angles.
    pub const PERFECT: Metal = Metal {
        eta: Vec3::ZERO,
        k: Vec3::ONE,
    };

    /// A metal of eta 1 that reflects `f0` at normal incidence, as pbrt's version 4 makes one:
    /// k = 2 sqrt(f0 / (1 - f0)).
    pub fn of_reflectance(f0: Vec3) -> Metal {
        let r = f0.clamp(Vec3::ZERO, Vec3::splat(0.9999));
        Metal {
            eta: Vec3::ONE,
            k: (r / (Vec3::ONE - r)).map(f32::sqrt) * 2.0,
        }
    }
}

impl Material {
    /// Metal, without textures; `tint` is a factor of its reflectance.
    pub fn conductor(name: impl Into<String>, metal: Metal, tint: Vec3, roughness: f32) -> Self {
        let own = |value| Parameter {
            value,
            texture: INVALID,
        };
        Self {
            kind: &CONDUCTOR,
            roughness,
            metallic: 1.0,
            specular: 0.5,
            own: vec![own(metal.eta), own(metal.k)],
            ..Self::lambert(name, tint)
        }
    }
}

#[inline(always)]
fn fresnel(bsdf: &Bsdf, cosine: f32) -> Vec3 {
    let [a, b, c, d, e, f, ..] = bsdf.own;
    bsdf.base_color * conductor(cosine, Vec3::new(a, b, c), Vec3::new(d, e, f))
}

/// f cos(theta_l).
#[inline(always)]
fn eval(bsdf: &Bsdf, n: Vec3, v: Vec3, l: Vec3) -> Vec3 {
    let (cos_v, cos_l) = (n.dot(v), n.dot(l));
    let half = Half::new(n, v, l);
    let alpha = alpha(bsdf.roughness);
    let lobe = ggx(&half, alpha) * smith(cos_v, alpha) * smith(cos_l, alpha) / (4.0 * cos_v);
    let value = fresnel(bsdf, half.cos_d) * lobe;
    pick((cos_v > 0.0) & (cos_l > 0.0), value, Vec3::ZERO)
}

/// A direction mirrored at a microfacet that the viewer sees, by the last two of three numbers.
#[inline(always)]
fn sample(bsdf: &Bsdf, n: Vec3, v: Vec3, u: [f32; 3]) -> Scatter {
    let frame = ShadingFrame::new(n);
    let local = frame.to_local(v);
    let h = visible_normal(local, alpha(bsdf.roughness), [u[1], u[2]]);
    let l = frame.to_world(mirrored(local, h));
    let pdf = pdf(bsdf, n, v, l);
    Scatter::weighted(l, eval(bsdf, n, v, l), pdf)
}

/// Density of [`sample`].
#[inline(always)]
fn pdf(bsdf: &Bsdf, n: Vec3, v: Vec3, l: Vec3) -> f32 {
    let (cos_v, cos_l) = (n.dot(v), n.dot(l));
    let half = Half::new(n, v, l);
    let density = visible_normal_density(&half, cos_v, alpha(bsdf.roughness));
    if (cos_v > 0.0) & (cos_l > 0.0) {
        density / (4.0 * half.cos_d)
    } else {
        0.0
    }
}
