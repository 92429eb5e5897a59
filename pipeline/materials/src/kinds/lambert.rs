//! Ideal diffuse reflection: f = base colour / pi.

use crate::kind::{OWN, scatter_lanes};
use crate::math::{pick, sin_cos_turn};
use crate::opaque;
use crate::{
    Bsdf, INVALID, Material, MaterialKind, MaterialLanes, Opacity, Parts, Scatter, ShadingFrame,
    Slot, Storage,
};
use glam::Vec3;
use std::f32::consts::FRAC_1_PI;

/// Ideal diffuse reflection.
pub static LAMBERT: MaterialKind = MaterialKind {
    name: "lambert",
    number: 0,
    slots: &[Slot::new("base colour", "reflectance", Storage::BaseColor)],
    mitsuba: "diffuse",
    depends_on_viewer: false,
    is_black: |bsdf| bsdf.base_color == Vec3::ZERO,
    transmits: false,
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

scatter_lanes!(LAMBERT);

impl Material {
    /// Ideal diffuse reflection, without textures.
    pub fn lambert(name: impl Into<String>, base_color: Vec3) -> Self {
        Self {
            name: name.into(),
            kind: &LAMBERT,
            base_color,
            roughness: 1.0,
            metallic: 0.0,
            specular: 0.0,
            own: Vec::new(),
            opacity: Opacity::OPAQUE,
            base_texture: INVALID,
            roughness_metallic_texture: INVALID,
            normal_texture: INVALID,
        }
    }
}

impl Bsdf {
    /// Reflects nothing.
    pub const BLACK: Bsdf = Bsdf {
        kind: &LAMBERT,
        base_color: Vec3::ZERO,
        roughness: 1.0,
        metallic: 0.0,
        specular: 0.0,
        own: [0.0; OWN],
        parts: Parts::ALL,
        eta: 1.0,
        inside: false,
    };
}

/// The most frequent kind within the loops of others, where all lanes are of it.
impl MaterialLanes {
    /// Whether all lanes are Lambert.
    #[inline(always)]
    pub fn all_diffuse(&self) -> bool {
        self.has_only(&LAMBERT)
    }

    /// Value and density of lane `i`, taken to be Lambert.
    #[inline(always)]
    pub fn diffuse(&self, i: usize, n: Vec3, v: Vec3, l: Vec3) -> (Vec3, f32) {
        let bsdf = self.get(i, &LAMBERT);
        (eval(&bsdf, n, v, l), pdf(&bsdf, n, v, l))
    }

    /// A direction of lane `i`, taken to be Lambert.
    #[inline(always)]
    pub fn diffuse_sample(&self, i: usize, n: Vec3, v: Vec3, u: [f32; 3]) -> Scatter {
        sample(&self.get(i, &LAMBERT), n, v, u)
    }
}

/// f cos(theta_l).
#[inline(always)]
fn eval(bsdf: &Bsdf, n: Vec3, v: Vec3, l: Vec3) -> Vec3 {
    bsdf.base_color * pdf(bsdf, n, v, l)
}

/// A cosine-weighted direction from the last two of three numbers.
#[inline(always)]
fn sample(bsdf: &Bsdf, n: Vec3, v: Vec3, u: [f32; 3]) -> Scatter {
    let l = ShadingFrame::new(n).to_world(cosine_hemisphere([u[1], u[2]]));
    let pdf = pdf(bsdf, n, v, l);
    Scatter {
        l,
        weight: pick(pdf > 0.0, bsdf.base_color, Vec3::ZERO),
        pdf,
    }
}

/// cos(theta_l) / pi above the surface.
#[inline(always)]
fn pdf(_: &Bsdf, n: Vec3, v: Vec3, l: Vec3) -> f32 {
    if n.dot(v) > 0.0 {
        cosine_hemisphere_pdf(n.dot(l))
    } else {
        0.0
    }
}

/// A unit vector about (0, 0, 1) with density cos(theta) / pi with respect to solid angle
/// (Malley's method: a uniform disk lifted onto the hemisphere).
#[inline(always)]
pub fn cosine_hemisphere(u: [f32; 2]) -> Vec3 {
    let radius = u[0].sqrt();
    let (sine, cosine) = sin_cos_turn(u[1]);
    Vec3::new(radius * cosine, radius * sine, (1.0 - u[0]).sqrt())
}

/// Density of [`cosine_hemisphere`] from cos(theta).
#[inline(always)]
pub fn cosine_hemisphere_pdf(cosine: f32) -> f32 {
    if cosine > 0.0 {
        cosine * FRAC_1_PI
    } else {
        0.0
    }
}
