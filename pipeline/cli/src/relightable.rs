//! A transfer with its lights as tensors: `rrf export --safetensors`.

use crate::args::CameraArgs;
use crate::baked::{Baked, BakedModel};
use crate::failure::BadInput;
use rrf_export::transfer::{TensorLight, write_transfer_tensors};
use rrf_lights::LightSource;
use rrf_scene::Scene;
use rrf_trace::Tracer;
use rrf_transfer::{LightBook, TRUST_ERROR};
use std::path::Path;

/// Writes the model of a run and the light that each light of a frame throws on its patches; returns how many
/// lights.
pub fn write_relightable(
    run: &Path,
    camera: &CameraArgs,
    file: &Path,
    facts: &[(&str, String)],
) -> anyhow::Result<usize> {
    let baked = Baked::open(run, TRUST_ERROR)?;
    let BakedModel::Transfer(model) = &baked.model else {
        return Err(BadInput(format!(
            "{}: is a run of nets, which have no lights to write beside them",
            run.display()
        ))
        .into());
    };
    let scene = camera.relit(&baked.scene)?;
    // says so where none shines
    camera.lights(&scene)?;
    let tracer = Tracer::new(&baked.unlit)?;
    let book = LightBook::new(model, &tracer)?;
    let lights = lights(camera, &scene, &book)?;
    write_transfer_tensors(file, model, &lights, facts)?;
    Ok(lights.len())
}

/// The scene's own lights one by one, and those that are typed.
fn lights(
    camera: &CameraArgs,
    scene: &Scene,
    book: &LightBook,
) -> anyhow::Result<Vec<TensorLight>> {
    let mut lights = Vec::new();
    let mut add = |name: String, sources: &[LightSource], lamps: Option<&Scene>| {
        let lit = book.under(sources, lamps)?;
        lights.push(TensorLight {
            name,
            irradiance: lit.irradiance().to_vec(),
            residual: lit.residual,
        });
        anyhow::Ok(())
    };
    if camera.shows_own_lights() {
        for name in scene.own_light_names() {
            let alone = scene.lit_by(name);
            let sources = alone.lights.iter().map(|light| light.source.clone());
            add(name.into(), &sources.collect::<Vec<_>>(), Some(&alone))?;
        }
    }
    for (k, point) in camera.typed().enumerate() {
        add(format!("point{k}"), &[point.into()], None)?;
    }
    for (k, sun) in camera.typed_suns().enumerate() {
        add(format!("sun{k}"), &[sun.into()], None)?;
    }
    Ok(lights)
}
