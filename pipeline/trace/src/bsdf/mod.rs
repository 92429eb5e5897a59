//! How a surface scatters light: value, sampler and density side by side.
//!
//! Local frame, normal (0, 0, 1). `v` points to the viewer and has v.z > 0; `l` points to
//! where the light comes from. Values are f(v, l) times cos(theta_l) [1/sr]; densities are with
//! respect to solid angle about `l`. Light from below the surface is never scattered.

mod lambert;

use glam::Vec3;
use rrf_scene::{Material, MaterialKind};

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
    /// Unit direction, local frame.
    pub l: Vec3,
    /// f cos(theta_l) / pdf.
    pub weight: Vec3,
    /// Density of `l` with respect to solid angle; zero when nothing was sampled.
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
    #[inline]
    pub fn eval(&self, v: Vec3, l: Vec3) -> Vec3 {
        lambert::eval(self.base_color, v, l)
    }

    /// Density of [`Bsdf::sample`] at `l`.
    #[inline]
    pub fn pdf(&self, v: Vec3, l: Vec3) -> f32 {
        lambert::pdf(v, l)
    }

    /// A direction from three numbers in [0, 1).
    #[inline]
    pub fn sample(&self, v: Vec3, u: [f32; 3]) -> Scatter {
        lambert::sample(self.base_color, v, u)
    }
}
