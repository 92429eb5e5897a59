//! A static scene as flat columns: triangles, materials, lights, cameras.
//!
//! [`load`] reads pbrt text (versions 3 and 4), glTF 2.0 and OBJ into one [`Scene`];
//! every later stage reads these columns and nothing else.
//!
//! A file's journey: `load` chooses the reader by the file's ending; the reader fills the
//! columns and notes in [`Scene::warnings`] what it approximates or leaves out; `validate`
//! checks what every scene must fulfil, and `sanitize` removes what no stage can use. From then
//! on ids are in range, numbers finite, and triangles have an area. [`Scene::hash`] names the
//! scene for a run's manifest, [`Scene::summary`] shows what was understood.
//!
//! ```
//! let path = std::path::Path::new("../../scenes/cornell-box/scene.pbrt");
//! let scene = rrf_scene::load(path, &rrf_scene::LoadOptions::default())?;
//! assert_eq!(scene.triangles.len(), 36);
//! println!("{}", scene.summary());
//! # Ok::<(), rrf_scene::SceneError>(())
//! ```

#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

mod adjust;
mod coplanar;
mod emission;
mod error;
mod file;
mod gltf;
mod load;
mod lost;
mod measure;
mod obj;
mod options;
mod own_lights;
mod pbrt;
mod pfm;
mod polygon;
mod relight;
mod resolve;
mod sanitize;
mod scene;
mod show;
mod sky;
mod summary;
mod texture;
mod validate;
mod warn;

#[cfg(test)]
mod tests;

pub use adjust::LightChangeError;
pub use error::SceneError;
pub use load::load;
pub use measure::Bounds;
pub use options::{LightUnits, LoadOptions, SkyOption, SkySource};
pub use rrf_lights::{AreaLight, LightSource, OwnLight, PointLight};
pub use rrf_materials::{INVALID, Material, MaterialKind, Texture};
pub use scene::{Camera, Scene, Warning};
pub use summary::{
    AreaLightSummary, CameraSummary, LightSummary, MaterialSummary, ObjectSummary, Summary,
    TextureSummary,
};
