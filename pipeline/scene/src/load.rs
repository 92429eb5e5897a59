//! One entry for every scene format.

use crate::sky::add_sky;
use crate::validate::validate;
use crate::{LoadOptions, Scene, SceneError, gltf, obj, pbrt};
use std::path::Path;

/// Reads a scene file; the ending chooses the format: `.pbrt`, `.gltf`, `.glb`, `.obj`,
/// or one of them with `.gz`.
///
/// Approximations and omissions are in [`Scene::warnings`]; what cannot be understood
/// is an error with its place. The scene returned is sound: columns of equal length, ids in
/// range, finite numbers, at least one triangle, none without area.
pub fn load(path: &Path, options: &LoadOptions) -> Result<Scene, SceneError> {
    let ending = |path: &Path| {
        path.extension()
            .map(|ending| ending.to_string_lossy().to_ascii_lowercase())
    };
    let ending = match ending(path).as_deref() {
        Some("gz") => ending(&path.with_extension("")),
        other => other.map(str::to_owned),
    };
    let mut scene = match ending.as_deref() {
        Some("pbrt") => pbrt::read(path, options),
        Some("gltf" | "glb") => gltf::read(path, options),
        Some("obj") => obj::read(path, options),
        _ => Err(SceneError::UnknownFormat {
            path: path.to_path_buf(),
        }),
    }?;
    if let Some(sky) = &options.sky {
        add_sky(&mut scene, sky)?;
    }
    validate(scene)
}
