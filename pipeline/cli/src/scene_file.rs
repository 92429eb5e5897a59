//! Scene files, and what was approximated in reading them.

use rrf_bake::settings::SceneOptions;
use rrf_scene::Scene;
use std::path::Path;

/// Loads a scene and says on standard error what was approximated.
pub fn load(path: &Path, options: &SceneOptions) -> anyhow::Result<Scene> {
    let scene = rrf_scene::load(path, &options.load_options())?;
    for warning in &scene.warnings {
        eprintln!("warning: {}: {}", warning.place, warning.message);
    }
    Ok(scene)
}
