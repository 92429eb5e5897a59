//! `rrf scene`: what was understood of a scene file.

use crate::args::SceneArgs;
use rrf_bake::settings::SceneOptions;
use rrf_scene::Scene;
use std::path::Path;

/// Prints the summary.
pub fn run(args: &SceneArgs) -> anyhow::Result<()> {
    let scene = rrf_scene::load(&args.scene, &args.scene_options.load_options())?;
    let summary = scene.summary();
    if args.json {
        println!("{}", serde_json::to_string_pretty(&summary)?);
    } else {
        println!("{summary}");
    }
    Ok(())
}

/// Loads a scene and says on standard error what was approximated.
pub fn load(path: &Path, options: &SceneOptions) -> anyhow::Result<Scene> {
    let scene = rrf_scene::load(path, &options.load_options())?;
    for warning in &scene.warnings {
        eprintln!("warning: {}: {}", warning.place, warning.message);
    }
    Ok(scene)
}
