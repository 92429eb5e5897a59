//! glTF 2.0 (`.gltf` with its buffers, `.glb`), flattened to world space.
//!
//! The `gltf` crate parses the JSON and checks its references. Its readers of binary data
//! trust offsets and counts, so that part is done here, with every range checked first
//! ([`accessor`]). Not read, with a warning: animation, skins, morph targets, vertex
//! colours, alpha, occlusion, orthographic cameras, and extensions
//! beyond [`document::EXTENSIONS`].
//!
//! Source: Khronos, glTF 2.0 specification (ISO/IEC 12113:2022) and its KHR extensions.

mod accessor;
mod buffers;
mod camera;
mod document;
mod ies;
mod layers;
mod light;
mod material;
mod mesh;
mod nodes;
mod output;
mod picture;
mod primitive;
mod specular;
mod uv;

use crate::{LoadOptions, Scene, SceneError};
use document::Document;
use material::Materials;
use output::Output;
use std::path::Path;

/// Reads a `.gltf` or `.glb` file.
pub(crate) fn read(path: &Path, options: &LoadOptions) -> Result<Scene, SceneError> {
    let bytes = crate::file::read_bytes(path)?;
    let (root, chunk) = document::parse(path, &bytes)?;
    let document = Document {
        path,
        root: &root,
        buffers: buffers::read(path, &root, chunk)?,
    };
    let mut output = Output::default();
    document::note_left_out(&root, &mut output.warnings);
    let mut materials = Materials::new(&document, options);
    for placed in nodes::flatten(&document, &mut output.warnings)? {
        mesh::add(&document, &placed, &mut materials, &mut output)?;
        light::add(&document, &placed, options, &mut output)?;
        ies::add(&document, &placed, &mut output)?;
        camera::add(&document, &placed, &mut output)?;
    }
    light::note_mixed_units(&root, options, &mut output);
    materials.finish(&mut output);
    let Output {
        scene, warnings, ..
    } = output;
    Ok(Scene {
        source: path.to_path_buf(),
        warnings: warnings.finish(),
        ..scene
    })
}
