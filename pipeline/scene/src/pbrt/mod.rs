//! The pbrt text format, versions 3 and 4.
//!
//! A file's journey: [`token`] splits text into words, [`params`] reads parameter lists,
//! [`directive`] follows one directive after another and keeps the graphics [`state`],
//! [`shape`], [`material`], [`texture`], [`light`] and [`camera`] turn what is declared into
//! the scene's columns. Format references: pbrt.org/fileformat-v3, pbrt.org/fileformat-v4.
//!
//! Where the versions differ, the first word that only one of them has decides
//! ([`Reader::version`]); without any, version 4.

mod camera;
mod colour;
mod directive;
mod drafts;
mod emission;
mod fault;
mod gloss;
mod infinite;
mod light;
mod material;
mod medium;
mod mesh;
mod metal;
mod mix;
mod param;
mod params;
mod ply;
mod ply_body;
mod ply_faces;
mod ply_header;
mod reader;
mod revolve;
mod shape;
mod spectrum;
mod state;
mod texture;
mod token;
mod transform;
mod value;
mod world;

#[cfg(test)]
mod tests;

use crate::{LoadOptions, Scene, SceneError};
use reader::Reader;
use std::path::Path;

/// Reads a pbrt file and all that it includes. pbrt has defaults of its own for everything
/// that a file leaves out; of the options only a lost picture's albedo counts here, and a sky,
/// which replaces one whose picture is lost.
pub(crate) fn read(path: &Path, options: &LoadOptions) -> Result<Scene, SceneError> {
    let mut reader = Reader::new(path);
    reader.lost_albedo = options.default_albedo;
    reader.replaces_sky = options.sky.is_some();
    match reader.main_file(path) {
        Ok(()) => Ok(reader.finish()),
        Err(fault) => Err(reader.files.error(fault)),
    }
}
