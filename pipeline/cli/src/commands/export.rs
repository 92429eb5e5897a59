//! `rrf export`: the scene, or the baked nets, for other programs.

use crate::args::CameraArgs;
use crate::failure::BadInput;
use crate::relightable::write_relightable;
use crate::run_location::RunLocation;
use crate::scene_file;
use clap::Args;
use rrf_bake::settings::SceneOptions;
use rrf_bake::{Run, RunMethod, TransferRun};
use rrf_scene::{Camera, Scene};
use rrf_store::manifest::RunManifest;
use rrf_store::model;
use std::path::{Path, PathBuf};

/// Write the scene for Mitsuba 3, or the baked model as tensors, ONNX or Parquet.
#[derive(Args, Clone, Debug)]
#[command(group = clap::ArgGroup::new("format").required(true).multiple(true))]
pub struct ExportArgs {
    /// A run folder, or for --mitsuba a scene file.
    pub input: PathBuf,
    /// Folder for scene.xml, meshes and textures that Mitsuba 3 loads.
    #[arg(long, value_name = "DIR", group = "format")]
    pub mitsuba: Option<PathBuf>,
    /// File for the nets and their kd-tree; of a transfer for its model and, light by light, the light on its patches.
    #[arg(long, value_name = "F", group = "format")]
    pub safetensors: Option<PathBuf>,
    /// File for the nets and their kd-tree as one ONNX graph.
    #[arg(long, value_name = "F", group = "format")]
    pub onnx: Option<PathBuf>,
    /// Folder for copies of the model's tables in Parquet, which DuckDB reads.
    #[arg(long, value_name = "DIR", group = "format")]
    pub parquet: Option<PathBuf>,
    /// Camera and lights that go into --mitsuba's scene, and lights of a transfer's tensors.
    #[command(flatten)]
    pub camera: CameraArgs,
    /// Reading the scene.
    #[command(flatten)]
    pub scene_options: SceneOptions,
}

/// Writes what was asked for.
pub fn run(args: &ExportArgs) -> anyhow::Result<()> {
    for file in args.safetensors.iter().chain(&args.onnx) {
        rrf_store::atomic::check_writable(file)?;
    }
    for folder in args.mitsuba.iter().chain(&args.parquet) {
        rrf_store::atomic::create_folder(folder)?;
    }
    let location = RunLocation::model(&args.input)?;
    let (folder, input) = (location.folder(), args.input.display());
    let method = folder.is_dir().then(|| RunMethod::of(folder)).transpose()?;
    if let Some(target) = &args.mitsuba {
        let scene = match method {
            Some(RunMethod::Nets) => Run::open(folder)?.load_scene()?,
            Some(RunMethod::Transfer) => TransferRun::open(folder)?.load_scene()?,
            None => scene_file::load(&args.input, &args.scene_options)?,
        };
        mitsuba(args, &scene, target)?;
    }
    if args.safetensors.is_none() && args.onnx.is_none() && args.parquet.is_none() {
        return Ok(());
    }
    let told = match method {
        Some(RunMethod::Nets) => return nets(args, &Run::open(folder)?),
        Some(RunMethod::Transfer) => return transfer(args, &TransferRun::open(folder)?),
        None => format!("{input}: is a scene, which has no nets; name a run folder"),
    };
    Err(BadInput(told).into())
}

fn transfer(args: &ExportArgs, run: &TransferRun) -> anyhow::Result<()> {
    if args.onnx.is_some() {
        let told = format!(
            "{}: is a run of a transfer, whose cells are chosen by surfaces and need a light: no graph of ONNX. \
             --onnx is for runs of `--method nets`; --safetensors writes a transfer with its lights",
            args.input.display()
        );
        return Err(BadInput(told).into());
    }
    if let Some(folder) = &args.parquet {
        let written = model::write_transfer_copies(&run.folder, folder, &run.facts())?;
        print_paths(&written);
    }
    if let Some(file) = &args.safetensors {
        let lights = write_relightable(&args.input, &args.camera, file, &facts(&run.manifest))?;
        println!("{lights} lights: {}", file.display());
    }
    Ok(())
}

fn facts(manifest: &RunManifest) -> [(&'static str, String); 3] {
    [
        ("created_by", manifest.created_by.clone()),
        ("scene_hash", manifest.scene_hash.clone()),
        ("seed", manifest.seed.to_string()),
    ]
}

fn print_paths(paths: &[PathBuf]) {
    for path in paths {
        println!("{}", path.display());
    }
}

fn mitsuba(args: &ExportArgs, scene: &Scene, folder: &Path) -> anyhow::Result<()> {
    let scene = args.camera.relit(scene)?;
    let scene = scene.as_ref();
    let lights = args.camera.lights(scene)?;
    let camera = if args.camera.eye.is_some() || !scene.cameras.is_empty() {
        Some(camera(args.camera.view(scene)?))
    } else {
        None
    };
    let mut lit = if lights.area {
        scene.clone()
    } else {
        scene.unlit()
    };
    lit.lights.extend(args.camera.suns());
    let points: Vec<_> = args.camera.typed().collect();
    for note in rrf_export::mitsuba::write_mitsuba(folder, &lit, camera.as_ref(), &points)? {
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
    let facts = facts(&run.manifest);
    if let Some(folder) = &args.parquet {
        print_paths(&model::write_parquet_copies(
            &run.folder,
            folder,
            &run.facts(),
        )?);
    }
    let (tree, cells) = (&model.tree.tree, &model.cells);
    if let Some(file) = &args.safetensors {
        rrf_export::tensors::write_safetensors(file, tree, cells, &facts)?;
        println!("{} nets: {}", cells.len(), file.display());
    }
    if let Some(file) = &args.onnx {
        rrf_export::onnx::write_onnx(file, tree, cells, &facts)?;
        println!("{} nets: {}", cells.len(), file.display());
    }
    Ok(())
}
