//! A static scene as flat columns: triangles, materials, lights, cameras.
//!
//! [`load`] reads pbrt text (versions 3 and 4), glTF 2.0 and OBJ into one [`Scene`];
//! every later stage reads these columns and nothing else.

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

mod error;
mod load;
mod measure;
mod mend;
mod options;
mod pbrt;
mod scene;
mod show;
mod summary;
mod validate;

#[cfg(test)]
mod tests;

pub use error::SceneError;
pub use load::load;
pub use measure::Bounds;
pub use options::{LightUnits, LoadOptions};
pub use scene::{
    AreaLight, Camera, INVALID, Material, MaterialKind, PointLight, Scene, Texture, Warning,
};
pub use summary::{
    AreaLightSummary, CameraSummary, MaterialSummary, ObjectSummary, PointLightSummary, Summary,
    TextureSummary,
};
