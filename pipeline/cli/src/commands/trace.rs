//! `rrf trace`: ground truth, as a picture or at points.

use crate::args::ViewArgs;
use crate::failure::BadInput;
use crate::table_lights::{LitRows, TableLight, by_light};
use crate::{memory, pictures, points, progress, reach, scene_file};
use arrow::array::{ArrayRef, Float32Array, RecordBatch};
use clap::{Args, ValueEnum};
use glam::Vec3;
use indicatif::ProgressBar;
use rrf_bake::settings::SceneOptions;
use rrf_render::{PathOptions, add_auxiliary};
use rrf_scene::Scene;
use rrf_store::Limits;
use rrf_store::points::{PointsTable, check_ending, read_points, with_columns, write_batch};
use rrf_store::schema::Table;
use rrf_trace::{Sampling, Tracer};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Render a frame, or the light at points, by path tracing: the ground truth.
#[derive(Args, Clone, Debug)]
pub struct TraceArgs {
    /// Scene file.
    pub scene: PathBuf,
    /// Picture (.exr, .png; again for more), or with --points the table to write.
    #[arg(short, long, value_name = "F", required = true)]
    pub output: Vec<PathBuf>,
    /// Paths a pixel, or a point: a multiple of 16 there.
    #[arg(long, value_name = "N", default_value_t = 256)]
    pub spp: u32,
    /// Points table: indirect radiance at its rows instead of a picture. A column `light` names each
    /// row's light: `point` (1 W/sr at l; where there is no name), `sun` (1 W/m² from direction l)
    /// or a light of the scene.
    #[arg(long, value_name = "IN.parquet", conflicts_with_all = ["eye", "look_at", "up", "mirror", "light", "scene_lights", "part", "aa", "aov", "exposure", "fov", "size", "sun", "dim", "moves", "own_lights"])]
    pub points: Option<PathBuf>,
    /// Estimator of paths to lights, with --points.
    #[arg(long, value_enum, default_value_t = Estimator::Bidirectional, requires = "points")]
    pub estimator: Estimator,
    /// Seed of every random number.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// View and lights.
    #[command(flatten)]
    pub view: ViewArgs,
    /// Reading the scene.
    #[command(flatten)]
    pub scene_options: SceneOptions,
}

/// Estimator of paths to lights; all are unbiased.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Estimator {
    /// Next-event estimation alone: the textbook estimator, the same as other path tracers'.
    NextEvent,
    /// Connections to the first hits of points of light too, as extraction traces its samples.
    Connected,
    /// Paths from both ends, joined in every way, and light shown by mirrors and polished balls: the
    /// least noise a path, for lights of every kind; a path takes ten to twenty times longer.
    Bidirectional,
}

/// Independent estimates a row, for the standard error.
const REPLICATES: u32 = 16;
/// Rows between two looks at the progress bar.
const BLOCK: usize = 64;

/// A picture, or with `--points` a table.
pub fn run(args: &TraceArgs, quiet: bool) -> anyhow::Result<()> {
    let scene = scene_file::load(&args.scene, &args.scene_options)?;
    match &args.points {
        Some(table) => trace_points(args, &scene, table, quiet),
        None => {
            let scene = args.view.camera.relit(&scene)?;
            trace_frame(args, &scene, quiet)
        }
    }
}

fn trace_frame(args: &TraceArgs, scene: &Scene, quiet: bool) -> anyhow::Result<()> {
    pictures::check_endings(&args.output)?;
    let view = args.view.camera.view(scene)?;
    memory::check_frame(view.width, view.height)?;
    let lights = args.view.camera.lights(scene)?;
    let lit = match lights.area {
        true => Cow::Borrowed(scene),
        false => Cow::Owned(scene.unlit()),
    };
    let tracer = Tracer::new(&lit)?;
    reach::warn(&tracer, &lights.sources, &[view.eye]);
    let bar = progress::bar(quiet, u64::from(view.height), "trace");
    let options = PathOptions {
        spp: args.spp,
        aa: args.view.aa,
        seed: args.seed,
    };
    let progress = |rows| bar.inc(rows);
    let mut frame = rrf_render::trace_frame(&tracer, &view, &lights, options, &progress)?;
    bar.finish_and_clear();
    add_auxiliary(
        &tracer,
        &view,
        args.view.aa,
        &args.view.auxiliary(),
        &mut frame,
    );
    pictures::write(frame, &args.view, &args.output)
}

fn trace_points(args: &TraceArgs, scene: &Scene, input: &Path, quiet: bool) -> anyhow::Result<()> {
    let [output] = args.output.as_slice() else {
        return Err(BadInput("--points writes one table; give -o once".into()).into());
    };
    check_ending(output)?;
    let table = read_points(input, Limits::default())?;
    let batch = truth(args, scene, &table, input, quiet)?;
    write_batch(output, Table::Truth, &batch)?;
    println!(
        "{} rows, {} paths each: {}",
        table.len(),
        args.spp,
        output.display()
    );
    Ok(())
}

/// A table's rows with `r g b r_se g_se b_se` appended; `input` is what errors call it.
pub fn truth(
    args: &TraceArgs,
    scene: &Scene,
    table: &PointsTable,
    input: &Path,
    quiet: bool,
) -> anyhow::Result<RecordBatch> {
    if !args.spp.is_multiple_of(REPLICATES) || args.spp == 0 {
        return Err(BadInput(format!(
            "--spp {}: with --points a multiple of {REPLICATES} is needed: the standard error \
             comes from {REPLICATES} independent estimates a row",
            args.spp
        ))
        .into());
    }
    let groups = by_light(table, scene, input)?;
    let (own, other): (Vec<LitRows>, Vec<LitRows>) = groups.into_iter().partition(LitRows::is_own);
    let mut answers = Answers {
        mean: vec![Vec3::ZERO; table.len()],
        error: vec![Vec3::ZERO; table.len()],
        bar: progress::bar(quiet, table.len() as u64, "trace"),
    };
    if !other.is_empty() {
        let unlit = scene.unlit();
        answers.trace(args, &Tracer::new(&unlit)?, (table, input), &other)?;
    }
    if !own.is_empty() {
        answers.trace(args, &Tracer::new(scene)?, (table, input), &own)?;
    }
    answers.bar.finish_and_clear();
    let Answers { mean, error, .. } = answers;
    let added: BTreeMap<&str, ArrayRef> = BTreeMap::from([
        ("r", channel(&mean, 0)),
        ("g", channel(&mean, 1)),
        ("b", channel(&mean, 2)),
        ("r_se", channel(&error, 0)),
        ("g_se", channel(&error, 1)),
        ("b_se", channel(&error, 2)),
    ]);
    let facts = points::facts(&scene.hash_hex(), args.seed);
    Ok(with_columns(&table.batch, Table::Truth, added, &facts)?)
}

/// Radiance of a table's rows, and its standard error.
struct Answers {
    mean: Vec<Vec3>,
    error: Vec<Vec3>,
    bar: ProgressBar,
}

impl Answers {
    /// Traces the rows of lights that shine in one tracer's scene.
    fn trace(
        &mut self,
        args: &TraceArgs,
        tracer: &Tracer,
        (table, input): (&PointsTable, &Path),
        groups: &[LitRows],
    ) -> anyhow::Result<()> {
        let estimator = match args.estimator {
            Estimator::NextEvent => rrf_trace::Estimator::NextEvent,
            Estimator::Connected => rrf_trace::Estimator::Connected,
            Estimator::Bidirectional => rrf_trace::Estimator::Bidirectional,
        };
        let sampling = Sampling {
            paths: args.spp,
            replicates: REPLICATES,
        };
        for group in groups {
            let light = TableLight::new(tracer, table, group, (estimator, args.seed), input)?;
            for first in (0..group.rows.len()).step_by(BLOCK) {
                let end = (first + BLOCK).min(group.rows.len());
                let estimates = light.trace((first, end), sampling)?;
                for (query, &row) in group.rows[first..end].iter().enumerate() {
                    self.mean[row] = estimates.mean(query);
                    self.error[row] = estimates.standard_error(query);
                }
                self.bar.inc((end - first) as u64);
            }
        }
        Ok(())
    }
}

fn channel(values: &[Vec3], c: usize) -> ArrayRef {
    Arc::new(Float32Array::from_iter_values(values.iter().map(|v| v[c])))
}
