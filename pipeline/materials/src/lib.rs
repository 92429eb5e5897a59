//! Materials: how a surface scatters light, and everything else that depends on its kind.
//!
//! A kind of material is one file in `kinds/`: its value, sampler and density side by side, and a
//! [`MaterialKind`] with its parameters, its name in summaries, its number in the scene hash, its
//! Mitsuba plugin, and whether its light depends on the viewer. [`KINDS`] lists them; no other
//! crate asks which kind a material is. Readers map their formats onto a [`Material`], which carries
//! textures; [`Bsdf`] has the parameters at one point; [`MaterialLanes`] those of sixty-four
//! points as columns, which each kind present shades at once.
//!
//! ```
//! use glam::Vec3;
//! use rrf_materials::{Bsdf, Material};
//!
//! let brass = Material::principled("brass", Vec3::new(0.9, 0.7, 0.3), 0.3, 1.0, 0.5);
//! assert!(brass.kind.depends_on_viewer);
//! let bsdf = Bsdf::of(&brass);
//! let (normal, viewer) = (Vec3::Z, Vec3::new(0.6, 0.0, 0.8));
//! let scattered = bsdf.sample(normal, viewer, [0.3, 0.5, 0.7]);
//! // the weight is the value, cosine included, over the density
//! let value = bsdf.eval(normal, viewer, scattered.l);
//! assert_eq!(scattered.weight, value / bsdf.pdf(normal, viewer, scattered.l));
//! ```
//!
//! [`Bsdf::broad`] and [`Bsdf::narrow`] take a material apart into what nets answer for and what is
//! followed along the ray.
//!
//! To add a kind: a file in `kinds/` after the model of `kinds/principled.rs`, and its lines in
//! `kinds/mod.rs`.

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

mod frame;
mod fresnel;
mod ggx;
mod kind;
mod kinds;
mod lanes;
mod material;
pub mod math;
mod opacity;
mod opaque;
mod parts;
mod refraction;
mod shade;
mod slot;
mod split;
mod texture;

pub use frame::ShadingFrame;
pub use ggx::{visible_normal, visible_normal_pdf};
pub use kind::{Bsdf, CERTAIN, Lobe, MaterialKind, MaterialLanes, Scatter, Scattered};
pub use kinds::{
    CONDUCTOR, DIELECTRIC, DIFFUSE_TRANSMISSION, KINDS, LAMBERT, Layers, Metal, PLASTIC,
    PRINCIPLED, PRINCIPLED_EXTENDED, ROUGH_DIELECTRIC, THIN_DIELECTRIC, cosine_hemisphere,
    cosine_hemisphere_pdf,
};
pub use lanes::{Lane, Lane3, TILE};
pub use material::{Material, Parameter, SlotValue};
pub use opacity::Opacity;
pub use parts::{BROAD_ROUGHNESS, Parts};
pub use slot::{Slot, Storage};
pub use texture::{INVALID, Texture};
