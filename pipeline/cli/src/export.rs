//! `rrf export`: the scene, or the baked nets, for other programs.

use crate::args::ExportArgs;
use crate::failure::BadInput;
use crate::place::Place;
use crate::{scene, view};
use rrf_bake::Run;
use rrf_scene::{Camera, Scene};
use rrf_store::model;
use std::path::Path;

/// Writes what was asked for.
pub fn run(args: &ExportArgs) -> anyhow::Result<()> {
    let place = Place::model(&args.input)?;
    let run = place.folder().is_dir().then(|| Run::open(place.folder()));
    let run = run.transpose()?;
    if let Some(folder) = &args.mitsuba {
        let scene = match &run {
            Some(run) => run.load_scene()?,
            None => scene::load(&args.input, &args.scene_options)?,
        };
        mitsuba(args, &scene, folder)?;
    }
    if args.safetensors.is_some() || args.onnx.is_some() {
        let Some(run) = &run else {
            return Err(BadInput(format!(
                "{}: nets are in a run folder, not in a scene",
                args.input.display()
            ))
            .into());
        };
        nets(args, run)?;
    }
    Ok(())
}

fn mitsuba(args: &ExportArgs, scene: &Scene, folder: &Path) -> anyhow::Result<()> {
    let lights = view::lights(&args.camera, scene)?;
    let camera = if args.camera.eye.is_some() || !scene.cameras.is_empty() {
        Some(camera(view::view(&args.camera, scene)?))
    } else {
        None
    };
    let lit = if lights.area {
        scene.clone()
    } else {
        scene.unlit()
    };
    for note in rrf_export::mitsuba::write(folder, &lit, camera.as_ref(), &lights.points)? {
        eprintln!("warning: {note}");
    }
    println!("{}", folder.join("scene.xml").display());
    Ok(())
}

fn camera(view: rrf_render::View) -> Camera {
    Camera {
        name: "view".into(),
        eye: view.eye,
        right: view.right,
        up: view.up,
        forward: view.forward,
        fov: view.fov,
        width: view.width,
        height: view.height,
    }
}

fn nets(args: &ExportArgs, run: &Run) -> anyhow::Result<()> {
    let model = model::read_model(&run.folder, &run.facts())?;
    let manifest = &run.manifest;
    let facts = [
        ("created_by", manifest.created_by.clone()),
        ("scene_hash", manifest.scene_hash.clone()),
        ("seed", manifest.seed.to_string()),
    ];
    let (tree, cells) = (&model.tree.tree, &model.cells);
    if let Some(file) = &args.safetensors {
        rrf_export::tensors::write(file, tree, cells, &facts)?;
        println!("{} nets: {}", cells.len(), file.display());
    }
    if let Some(file) = &args.onnx {
        rrf_export::onnx::write(file, tree, cells, &facts)?;
        println!("{} nets: {}", cells.len(), file.display());
    }
    Ok(())
}
