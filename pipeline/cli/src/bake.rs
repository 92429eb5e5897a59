//! `rrf bake`, `rrf extract`, `rrf train`.

use crate::args::{BakeArgs, ExtractArgs, TrainArgs, TrainMode};
use crate::progress::Bars;
use crate::scene;
use rrf_bake::{BakeConfig, Judgement, Preset, Run};
use rrf_extract::{Census, ExtractError, LightBox};
use rrf_scene::Scene;
use rrf_trace::Tracer;

/// The whole chain.
pub fn bake(args: &BakeArgs, quiet: bool) -> anyhow::Result<()> {
    let scene = scene::load(&args.scene, &args.scene_options)?;
    let config = config(args, &scene)?;
    let watch = Bars::new(quiet);
    let report = rrf_bake::bake(&scene, &config, &args.output, args.resume, &watch)?;
    print_census(&report.census);
    print_judgement(&report.judgement, config.target);
    println!(
        "extracted in {:.1} s, trained in {:.1} s: {}",
        report.extracting.as_secs_f64(),
        report.training.as_secs_f64(),
        args.output.display()
    );
    Ok(())
}

/// Load, plan, extract.
pub fn extract(args: &ExtractArgs, quiet: bool) -> anyhow::Result<()> {
    let bake = &args.bake;
    let scene = scene::load(&bake.scene, &bake.scene_options)?;
    let run = Run::create(&bake.output, &scene, &config(bake, &scene)?, bake.resume)?;
    let scene = scene.unlit();
    let tracer = Tracer::new(&scene)?;
    let plan = rrf_bake::plan(&run, &scene, &tracer)?;
    let only = (!args.cell.is_empty()).then_some(args.cell.as_slice());
    rrf_bake::extract(&run, &scene, &tracer, &plan, only, &Bars::new(quiet))?;
    print_census(&plan.census);
    println!(
        "{} cells planned: {}",
        plan.cells.len(),
        bake.output.display()
    );
    Ok(())
}

/// Train, judge.
pub fn train(args: &TrainArgs, quiet: bool) -> anyhow::Result<()> {
    let mut run = Run::open(&args.run)?;
    run.config.train.mode = mode(args);
    let plan = run.plan()?;
    rrf_bake::train(&run, &plan, &Bars::new(quiet))?;
    print_judgement(&rrf_bake::judge(&run, &plan)?, run.config.target);
    Ok(())
}

/// Steps on a batch: enough for its minimum, where the batch alone decides, a few where it only
/// corrects what the earlier ones taught.
const BATCH_STEPS: [usize; 2] = [10, 3];

fn mode(args: &TrainArgs) -> rrf_train::Mode {
    let batches = |steps| rrf_train::Batches {
        rows: args.batch as usize,
        steps,
        epochs: 1,
    };
    let [online, recursive] = BATCH_STEPS;
    match args.mode {
        TrainMode::Local => rrf_train::Mode::Local,
        TrainMode::Online => rrf_train::Mode::Online(batches(online)),
        TrainMode::Recursive => rrf_train::Mode::Recursive {
            batches: batches(recursive),
            forgetting: 1.0,
        },
    }
}

fn config(args: &BakeArgs, scene: &Scene) -> Result<BakeConfig, ExtractError> {
    let light_box = match args.light_box {
        Some([x0, y0, z0, x1, y1, z1]) => LightBox {
            minimum: [x0, y0, z0],
            maximum: [x1, y1, z1],
        },
        None => middle(scene)?,
    };
    let preset = match args.preset {
        crate::args::Preset::Preview => Preset::Preview,
        crate::args::Preset::Standard => Preset::Standard,
        crate::args::Preset::Fine => Preset::Fine,
    };
    let options = scene::options(&args.scene_options);
    let mut config = BakeConfig::preset(preset, light_box, args.seed);
    config.target = args.target;
    config.default_albedo = options.default_albedo;
    config.light_units = options.light_units;
    config.extract.rows = args.rows.unwrap_or(config.extract.rows);
    config.extract.paths = args.paths.unwrap_or(config.extract.paths);
    config.extract.cells = args.cells.unwrap_or(config.extract.cells);
    Ok(config)
}

/// The middle 80 % of the scene's bounds on each axis.
fn middle(scene: &Scene) -> Result<LightBox, ExtractError> {
    let bounds = scene.bounds().ok_or(ExtractError::NoTriangle)?;
    let inner = |i: usize, share: f32| bounds.min[i] + share * (bounds.max[i] - bounds.min[i]);
    let light_box = LightBox {
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
         {} points that see nothing, {} on black surfaces",
        census.accepted,
        census.light_in_solid,
        census.point_in_solid,
        census.sees_nothing,
        census.black
    );
}

fn print_judgement(judgement: &Judgement, target: f32) {
    let square = f64::from(target).powi(2);
    let missing = judgement
        .cells
        .iter()
        .filter(|c| c.square_error > square)
        .count();
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
