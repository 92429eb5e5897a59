//! `rrf scene`: what was understood of a scene file.

use clap::Args;
use rrf_bake::settings::SceneOptions;
use std::path::PathBuf;

/// Print what was understood of a scene file.
#[derive(Args, Clone, Debug)]
pub struct SceneArgs {
    /// Scene file.
    pub scene: PathBuf,
    /// Machine-readable output.
    #[arg(long)]
    pub json: bool,
    /// Reading the scene.
    #[command(flatten)]
    pub scene_options: SceneOptions,
}

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
