//! `rrf bake`, `rrf extract`, `rrf train`.

use crate::args::{BakeArgs, BakeSettings, ExtractArgs, TrainArgs, TrainMode};
use crate::method;
use crate::place::Place;
use crate::progress::Bars;
use crate::scene;
use rrf_bake::{BakeConfig, BakeError, Judgement, Next, Preset, Run, Site, Stage};
use rrf_extract::{Census, ExtractError, Region};
use rrf_scene::Scene;
use rrf_trace::Tracer;
use std::time::Instant;

/// The whole chain.
pub fn bake(args: &BakeArgs, quiet: bool) -> anyhow::Result<()> {
    let start = Instant::now();
    let scene = scene::load(&args.scene, &args.settings.scene_options)?;
    let config = config(&args.settings, &scene)?;
    let place = Place::whole(&args.output)?;
    let folder = place.folder().to_path_buf();
    let watch = Bars::new(quiet, &args.bounds)?.keeping(place);
    let ended = rrf_bake::bake(&scene, &config, &folder, args.settings.resume, &watch)?;
    print_census(&ended.census);
    print_judgement(&ended.judgement, config.target);
    println!(
        "{} rounds in {:.1} s, stopped because {}: {}",
        ended.rounds,
        start.elapsed().as_secs_f64(),
        ended.stop.text(),
        args.output.display()
    );
    Ok(())
}

/// Load, plan, extract.
pub fn extract(args: &ExtractArgs, quiet: bool) -> anyhow::Result<()> {
    let bake = &args.bake;
    let asked = &bake.settings;
    let scene = scene::load(&bake.scene, &asked.scene_options)?;
    let place = Place::whole(&bake.output)?;
    let run = Run::create(
        place.folder(),
        &scene,
        &config(asked, &scene)?,
        asked.resume,
    )?;
    let scene = scene.unlit();
    let tracer = Tracer::new(&scene)?;
    let site = Site::new(&scene, &tracer, &run.config)?;
    let first = rrf_bake::first_plan(&run, &site)?;
    let plan = rrf_bake::standing(&run)?.todo.unwrap_or(first);
    let only = (!args.cell.is_empty()).then_some(args.cell.as_slice());
    let last = plan.cells.len().saturating_sub(1) as u32;
    if let Some(&cell) = args.cell.iter().find(|&&cell| cell > last) {
        return Err(BakeError::NoSuchCell { cell, last }.into());
    }
    let watch = Bars::new(quiet, &bake.bounds)?.keeping(place);
    rrf_bake::perform_stage(&run, &plan, Some(&site), Stage::Extract, only, &watch)?;
    print_census(&plan.census);
    println!(
        "{} cells planned: {}",
        plan.cells.len(),
        bake.output.display()
    );
    Ok(())
}

/// Train, judge: the round that is extracted.
pub fn train(args: &TrainArgs, quiet: bool) -> anyhow::Result<()> {
    let place = Place::whole(&args.run)?;
    let mut run = Run::open(place.folder())?;
    run.config.train.mode = mode(args);
    let standing = rrf_bake::standing(&run)?;
    let Some(plan) = standing.todo else {
        let judged = standing.judged.ok_or_else(|| BakeError::NotExtracted {
            path: args.run.clone(),
            cell: 0,
        })?;
        println!("all rounds are trained");
        print_judgement(&judged.judgement, run.config.target);
        return Ok(());
    };
    let watch = Bars::new(quiet, &args.bounds)?.keeping(place);
    rrf_bake::perform_stage(&run, &plan, None, Stage::Train, None, &watch)?;
    let (judgement, next) = rrf_bake::finish_round(&run, &plan, None)?;
    watch.push()?;
    print_judgement(&judgement, run.config.target);
    match next {
        Next::Stop(stop) => println!("stopped because {}", stop.text()),
        Next::Round(next) => println!(
            "round {} is planned, {} cells: go on by `rrf bake --resume`",
            next.round,
            next.cells.len()
        ),
    }
    Ok(())
}

/// Steps on a batch: enough for its minimum, where the batch alone decides, a few where it only
/// corrects what the earlier ones taught.
const BATCH_STEPS: [usize; 2] = [10, 3];

fn mode(args: &TrainArgs) -> rrf_train::Schedule {
    let batches = |steps| rrf_train::Batches {
        rows: args.batch as usize,
        steps,
    };
    let [online, recursive] = BATCH_STEPS;
    match args.mode {
        TrainMode::Local => rrf_train::Schedule::Local,
        TrainMode::Online => rrf_train::Schedule::Online(batches(online)),
        TrainMode::Recursive => rrf_train::Schedule::Recursive(batches(recursive)),
    }
}

/// The settings that the arguments mean.
pub fn config(args: &BakeSettings, scene: &Scene) -> anyhow::Result<BakeConfig> {
    let light_box = match args.light_box {
        Some(corners) => boxed(corners),
        None => middle(scene)?,
    };
    let preset = match args.preset {
        crate::args::Preset::Preview => Preset::Preview,
        crate::args::Preset::Standard => Preset::Standard,
        crate::args::Preset::Fine => Preset::Fine,
    };
    let options = scene::options(&args.scene_options);
    let mut config = BakeConfig::preset(preset, light_box, args.seed);
    config.extract.eye_box = args.eye_box.map(boxed);
    config.target = args.target;
    config.default_albedo = options.default_albedo;
    config.light_units = options.light_units;
    config.extract.rows = args.rows.unwrap_or(config.extract.rows);
    config.extract.paths = args.paths.unwrap_or(config.extract.paths);
    config.extract.cells = args.cells.unwrap_or(config.extract.cells);
    config.rounds = args.rounds.unwrap_or(config.rounds);
    config.most_cells = args
        .most_cells
        .unwrap_or(config.most_cells.max(config.extract.cells));
    config.trim = !args.no_trim;
    method::set(&mut config, args, scene)?;
    if let Some(inputs) = &args.inputs {
        config.train.inputs.clone_from(inputs);
        config.train.drop_redundant = false;
    }
    Ok(config)
}

fn boxed([x0, y0, z0, x1, y1, z1]: [f32; 6]) -> Region {
    Region {
        minimum: [x0, y0, z0],
        maximum: [x1, y1, z1],
    }
}

/// The middle 80 % of the scene's bounds on each axis.
fn middle(scene: &Scene) -> Result<Region, ExtractError> {
    let bounds = scene.bounds().ok_or(ExtractError::NoTriangle)?;
    let inner = |i: usize, share: f32| bounds.min[i] + share * (bounds.max[i] - bounds.min[i]);
    let light_box = Region {
        minimum: std::array::from_fn(|i| inner(i, 0.1)),
        maximum: std::array::from_fn(|i| inner(i, 0.9)),
    };
    eprintln!(
        "no --light-box: lights may stand in the middle 80 % of the scene, {:?} to {:?}",
        light_box.minimum, light_box.maximum
    );
    Ok(light_box)
}

fn print_census(census: &Census) {
    println!(
        "candidates: {} accepted; left out: {} lights inside solids, {} points inside solids, \
         {} points that see nothing, {} on black surfaces{}",
        census.accepted,
        census.light_in_solid,
        census.point_in_solid,
        census.sees_nothing,
        census.black,
        match census.unseen {
            0 => String::new(),
            unseen => format!(", {unseen} that no eye sees"),
        }
    );
}

/// The error of the whole, with its definition.
pub fn print_judgement(judgement: &Judgement, target: f32) {
    let square = f64::from(target).powi(2);
    let missing = judgement
        .cells
        .iter()
        .filter(|c| c.square_error > square)
        .count();
    if let Some(test) = judgement.test {
        println!(
            "relative error: {:.2} % ± {:.2} % (target {:.2} %), on {} test rows, which no net was fitted to",
            100.0 * test.relative_error,
            100.0 * test.relative_error_se,
            100.0 * target,
            test.rows
        );
    }
    println!(
        "relative error on rows held out: {:.2} % ± {:.2} % (target {:.2} %); {} of {} cells miss it",
        100.0 * judgement.relative_error,
        100.0 * judgement.relative_error_se,
        100.0 * target,
        missing,
        judgement.cells.len()
    );
    println!(
        "  relative error: sqrt(mean((p-m)² / max(lum(m), ε)²)), ε = 5 % of the mean luminance, Monte Carlo noise taken out"
    );
}
