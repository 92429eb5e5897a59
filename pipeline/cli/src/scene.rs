//! `rrf scene`: what was understood of a scene file.

use crate::args::{LightUnits, SceneArgs, SceneOptions};
use rrf_scene::{LoadOptions, Scene};
use std::path::Path;

/// Prints the summary.
pub fn run(args: &SceneArgs) -> anyhow::Result<()> {
    let scene = rrf_scene::load(&args.scene, &options(&args.scene_options))?;
    let summary = scene.summary();
    if args.json {
        println!("{}", serde_json::to_string_pretty(&summary)?);
    } else {
        println!("{summary}");
    }
    Ok(())
}

/// Loads a scene and says on standard error what was approximated.
pub fn load(path: &Path, typed: &SceneOptions) -> anyhow::Result<Scene> {
    let scene = rrf_scene::load(path, &options(typed))?;
    for warning in &scene.warnings {
        eprintln!("warning: {}: {}", warning.place, warning.message);
    }
    Ok(scene)
}

/// The library's form of what was typed.
pub fn options(typed: &SceneOptions) -> LoadOptions {
    LoadOptions {
        default_albedo: typed.default_albedo,
        light_units: match typed.light_units {
            LightUnits::Spec => rrf_scene::LightUnits::Spec,
            LightUnits::Compat => rrf_scene::LightUnits::Compat,
            LightUnits::Raw => rrf_scene::LightUnits::Raw,
        },
    }
}
