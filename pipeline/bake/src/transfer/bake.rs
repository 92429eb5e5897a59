//! The whole bake of a transfer.

use super::config::TransferBakeConfig;
use super::ensemble::{conditions, light_stream};
use super::observer::Observer;
use super::progress::Kept;
use super::read::is_damage;
use super::run::TransferRun;
use super::space::FreeSpace;
use super::summary::{TransferFacts, TransferSummary};
use super::tables::tables;
use super::test_rows::Tests;
use crate::error::BakeError;
use crate::exec::endless::refuse_endless;
use crate::exec::watch::Watch;
use rrf_scene::Scene;
use rrf_store::layout::remove_unfinished;
use rrf_store::model::write_transfer;
use rrf_trace::Tracer;
use rrf_transfer::{
    DirectLight, FlatMirrors, LightConditions, TransferModel, bake_transfer, named_light,
};
use std::path::Path;

/// The result of a transfer's bake.
#[derive(Clone, Copy, Debug)]
pub struct TransferOutcome {
    /// The model in a few numbers.
    pub summary: TransferSummary,
    /// Whether the run was finished before, so that nothing was done.
    pub was_finished: bool,
}

/// Bakes a scene's transfer into a run folder. An interrupted bake goes on with the surfaces that are left when
/// it is resumed, a finished one is left as it is, and one whose tables are damaged is made again, with the same
/// bytes.
///
/// # Errors
/// [`BakeError`] of any step; [`BakeError::TransferHalted`] where the watch stops it.
pub fn bake_scene_transfer(
    scene: &Scene,
    config: &TransferBakeConfig,
    folder: &Path,
    resume: bool,
    watch: &dyn Watch,
) -> Result<TransferOutcome, BakeError> {
    let unlit = scene.unlit();
    let halt = || watch.halted().is_some();
    let tracer = Tracer::new(&unlit)?.until(&halt);
    // before anything is written: a folder with a manifest counts as a run
    let space = FreeSpace::new(
        &unlit,
        &tracer,
        (config.eye_box, config.narrow),
        config.seed,
    )?;
    refuse_endless(&unlit, &tracer, "where eyes can be", |[u, ..]| {
        space.place(u)
    })?;
    let lights = light_stream(config.seed);
    let conditions = conditions(&unlit, &tracer, &space, config, lights)?;
    let run = TransferRun::create(folder, scene, config, resume)?;
    match run.model(&unlit) {
        Ok((model, facts)) => {
            // a byte that readers pass over may have changed: the files are made good
            write_transfer(folder, &tables(&model, &facts), &run.facts())?;
            return Ok(TransferOutcome {
                summary: TransferSummary::new(&model, facts, config.target),
                was_finished: true,
            });
        }
        Err(error) if is_damage(&error) => {}
        Err(error) => return Err(error),
    }
    watch.sync().map_err(BakeError::Sync)?;
    let facts = run.facts();
    let kept = || Kept {
        run: folder,
        facts: &facts,
    };
    let observer = Observer::new(watch, Some(kept()));
    let (model, lights) = make(scene, &space, &conditions, config, &observer)?;
    let tests = Tests {
        scene,
        space: &space,
        config,
        kept: scene.unlit_triangles(),
        watch,
    };
    let told = TransferFacts {
        lights,
        test: tests.run(&model)?,
    };
    remove_unfinished(folder)?;
    write_transfer(folder, &tables(&model, &told), &facts)?;
    kept().remove()?;
    watch.sync().map_err(BakeError::Sync)?;
    let summary = TransferSummary::new(&model, told, config.target);
    watch.transferred(&summary);
    Ok(TransferOutcome {
        summary,
        was_finished: false,
    })
}

/// The model, and how many lights it was fitted to.
pub(super) fn make(
    scene: &Scene,
    space: &FreeSpace,
    conditions: &LightConditions,
    config: &TransferBakeConfig,
    observer: &Observer,
) -> Result<(TransferModel, u32), BakeError> {
    let tracer = space.tracer();
    let stream = light_stream(config.seed);
    let names = scene.own_light_names();
    let own = names.iter();
    let own = own.filter_map(|name| named_light(scene, name, stream.part(3)));
    let drawn = conditions.lights(stream.part(4)).into_iter();
    let drawn = drawn.map(|group| Box::new(group) as Box<dyn DirectLight>);
    let mirrors = FlatMirrors::new(tracer);
    let lights: Vec<_> = drawn.chain(own).map(|light| mirrors.of(light)).collect();
    let lights: Vec<&dyn DirectLight> = lights.iter().map(|l| l as &dyn DirectLight).collect();
    let model = bake_transfer(tracer, space, &lights, &config.plan(), observer);
    observer.end();
    let model = model.map_err(|error| observer.why(error))?;
    Ok((model, lights.len() as u32))
}
