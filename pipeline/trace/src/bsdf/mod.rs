//! How a surface scatters light: value, sampler and density side by side.
//!
//! World frame. `n` is the unit shading normal on the viewer's side, `v` points to the
//! viewer (n.v > 0), `l` to where the light comes from. Values are f(v, l) cos(theta_l) [1/sr];
//! densities are with respect to solid angle about `l`. Light from below the surface is never
//! scattered. The functions are free of branches, so that loops over columns vectorise.

mod lambert;
mod principled;

use crate::math::pick;
use glam::Vec3;
use rrf_scene::{Material, MaterialKind};

pub use lambert::{cosine_hemisphere, cosine_hemisphere_pdf};
pub(crate) use principled::alpha;
pub use principled::{visible_normal, visible_normal_pdf};

/// Material parameters at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bsdf {
    /// Scattering model.
    pub kind: MaterialKind,
    /// Linear sRGB reflectance.
    pub base_color: Vec3,
    /// Perceptual roughness in [0, 1].
    pub roughness: f32,
    /// Metalness in [0, 1].
    pub metallic: f32,
    /// Dielectric specular in [0, 1].
    pub specular: f32,
}

/// A sampled direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatter {
    /// Unit direction, world frame.
    pub l: Vec3,
    /// f cos(theta_l) / pdf; zero when nothing is scattered there.
    pub weight: Vec3,
    /// Density of `l` with respect to solid angle.
    pub pdf: f32,
}

impl Bsdf {
    /// The constants of a material, textures left out.
    pub fn of(material: &Material) -> Bsdf {
        Bsdf {
            kind: material.kind,
            base_color: material.base_color,
            roughness: material.roughness,
            metallic: material.metallic,
            specular: material.specular,
        }
    }

    /// f(v, l) cos(theta_l) [1/sr].
    pub fn eval(&self, n: Vec3, v: Vec3, l: Vec3) -> Vec3 {
        match self.kind {
            MaterialKind::Lambert => lambert::eval(self, n, v, l),
            MaterialKind::Principled => principled::eval(self, n, v, l),
        }
    }

    /// Density of [`Bsdf::sample`] at `l`.
    pub fn pdf(&self, n: Vec3, v: Vec3, l: Vec3) -> f32 {
        self.eval_pdf::<true>(n, v, l).1
    }

    /// A direction from three numbers in [0, 1).
    pub fn sample(&self, n: Vec3, v: Vec3, u: [f32; 3]) -> Scatter {
        self.sample_lane::<true>(n, v, u)
    }

    /// Value and density together. Without `MIXED` every material is taken to be Lambert.
    #[inline(always)]
    pub(crate) fn eval_pdf<const MIXED: bool>(&self, n: Vec3, v: Vec3, l: Vec3) -> (Vec3, f32) {
        let diffuse = (lambert::eval(self, n, v, l), lambert::pdf(n, v, l));
        if !MIXED {
            return diffuse;
        }
        let rough = (
            principled::eval(self, n, v, l),
            principled::pdf(self, n, v, l),
        );
        let lambert = self.kind == MaterialKind::Lambert;
        let pdf = if lambert { diffuse.1 } else { rough.1 };
        (pick(lambert, diffuse.0, rough.0), pdf)
    }

    /// [`Bsdf::sample`] for a lane of a column.
    #[inline(always)]
    pub(crate) fn sample_lane<const MIXED: bool>(&self, n: Vec3, v: Vec3, u: [f32; 3]) -> Scatter {
        let diffuse = lambert::sample(self, n, v, u);
        if !MIXED {
            return diffuse;
        }
        let rough = principled::sample(self, n, v, u);
        let lambert = self.kind == MaterialKind::Lambert;
        Scatter {
            l: pick(lambert, diffuse.l, rough.l),
            weight: pick(lambert, diffuse.weight, rough.weight),
            pdf: if lambert { diffuse.pdf } else { rough.pdf },
        }
    }
}
