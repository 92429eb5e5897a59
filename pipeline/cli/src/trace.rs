//! `rrf trace`: ground truth, as a picture or at points.

use crate::args::TraceArgs;
use crate::failure::BadInput;
use crate::{pictures, points, progress, scene, view};
use arrow::array::{ArrayRef, Float32Array};
use glam::Vec3;
use rrf_field::columns;
use rrf_sampling::{Stage, Stream};
use rrf_scene::Scene;
use rrf_store::Limits;
use rrf_store::points::{check_ending, read_points, write_points};
use rrf_store::schema::Table;
use rrf_trace::{Estimator, Queries, Sampling, Tracer, indirect_with};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

/// Independent estimates a row, for the standard error.
const REPLICATES: u32 = 16;
/// Rows between two looks at the progress bar.
const BLOCK: usize = 64;

/// A picture, or with `--points` a table.
pub fn run(args: &TraceArgs, quiet: bool) -> anyhow::Result<()> {
    let scene = scene::load(&args.scene, &args.scene_options)?;
    match &args.points {
        Some(table) => {
            let unlit = scene.unlit();
            trace_points(args, &scene, &Tracer::new(&unlit)?, table, quiet)
        }
        None => trace_frame(args, &scene, quiet),
    }
}

fn trace_frame(args: &TraceArgs, scene: &Scene, quiet: bool) -> anyhow::Result<()> {
    pictures::check_endings(&args.output)?;
    let frame_view = view::view(&args.view.camera, scene)?;
    let lights = view::lights(&args.view.camera, scene)?;
    let unlit;
    let lit = if lights.area {
        scene
    } else {
        unlit = scene.unlit();
        &unlit
    };
    let tracer = Tracer::new(lit)?;
    let bar = progress::bar(quiet, u64::from(frame_view.height), "trace");
    let frame = rrf_render::trace_frame(
        &tracer,
        &frame_view,
        &lights,
        args.spp,
        args.view.aa,
        args.seed,
        &|rows| bar.inc(rows),
    )?;
    bar.finish_and_clear();
    pictures::write(frame, &args.view, &args.output)
}

fn trace_points(
    args: &TraceArgs,
    scene: &Scene,
    tracer: &Tracer,
    input: &Path,
    quiet: bool,
) -> anyhow::Result<()> {
    let [output] = args.output.as_slice() else {
        return Err(BadInput("--points writes one table: give -o once".into()).into());
    };
    check_ending(output)?;
    if !args.spp.is_multiple_of(REPLICATES) || args.spp == 0 {
        return Err(BadInput(format!(
            "--spp {}: with --points a multiple of {REPLICATES} is needed: the standard error \
             comes from {REPLICATES} independent estimates a row",
            args.spp
        ))
        .into());
    }
    let table = read_points(input, Limits::default())?;
    let located = points::locate(tracer, &table, input)?;
    let viewers = points::vectors(&table, columns::V);
    let lights = points::vectors(&table, columns::L);
    let stream = Stream::new(args.seed, Stage::Points, 0);
    let sampling = Sampling {
        paths: args.spp,
        replicates: REPLICATES,
    };
    let estimator = match args.estimator {
        crate::args::Estimator::NextEvent => Estimator::NextEvent,
        crate::args::Estimator::Connected => Estimator::Connected,
    };
    let bar = progress::bar(quiet, table.len() as u64, "trace");
    let mut mean = Vec::with_capacity(table.len());
    let mut error = Vec::with_capacity(table.len());
    for first in (0..table.len()).step_by(BLOCK) {
        let end = (first + BLOCK).min(table.len());
        let queries = Queries {
            points: &located[first..end],
            viewers: &viewers[first..end],
            lights: &lights[first..end],
        };
        let estimates = indirect_with(tracer, queries, sampling, estimator, stream, first as u64)?;
        for query in 0..estimates.len() {
            mean.push(estimates.mean(query));
            error.push(estimates.standard_error(query));
        }
        bar.inc((end - first) as u64);
    }
    bar.finish_and_clear();
    let added: BTreeMap<&str, ArrayRef> = BTreeMap::from([
        ("r", channel(&mean, 0)),
        ("g", channel(&mean, 1)),
        ("b", channel(&mean, 2)),
        ("r_se", channel(&error, 0)),
        ("g_se", channel(&error, 1)),
        ("b_se", channel(&error, 2)),
    ]);
    let facts = points::facts(&scene.hash_hex(), args.seed);
    write_points(output, &table.batch, Table::Truth, added, &facts)?;
    println!(
        "{} rows, {} paths each: {}",
        table.len(),
        args.spp,
        output.display()
    );
    Ok(())
}

fn channel(values: &[Vec3], c: usize) -> ArrayRef {
    Arc::new(Float32Array::from_iter_values(values.iter().map(|v| v[c])))
}
