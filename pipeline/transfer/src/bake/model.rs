//! A whole bake: patches, points, lights, and one batch of surfaces after another.

use super::batch::BatchTracer;
use super::compress::clustered;
use super::config::TransferConfig;
use super::draw::{PointDraw, choose, met};
use super::lighting::Lighting;
use super::memory::MemoryNeed;
use super::progress::TransferProgress;
use super::rounds::{RoundStreams, Rounds};
use super::sizes::{finer_sizes, uneven};
use super::sketch::Sketch;
use super::watch::{TransferStage, TransferWatch};
use crate::TransferError;
use crate::columns::ColumnTree;
use crate::irradiance::Receivers;
use crate::lights::DirectLight;
use crate::model::{TransferModel, receiver_stream};
use crate::patches::{PatchSizes, Patches};
use crate::query::{SurfaceKey, TransferQuery};
use crate::reflectance::Reflectances;
use crate::rows::{RowPoint, trace_rows};
use crate::tracing::{Stream, Tracer};
use glam::Vec3;
use rrf_sampling::Stage;
use std::collections::BTreeMap;

/// Nodes of the column tree that the residual is measured by, at most.
const SKETCH_NODES: usize = 4_096;
/// Share of the light that those may leave out.
const SKETCH_ERROR: f64 = 0.02;

/// Bakes a scene: everything but the lights, which are only examples of what may come.
///
/// The bits do not depend on the number of threads.
pub fn bake_transfer(
    tracer: &Tracer,
    points: &dyn PointDraw,
    lights: &[&dyn DirectLight],
    config: &TransferConfig,
    watch: &dyn TransferWatch,
) -> Result<TransferModel, TransferError> {
    let stream = Stream::new(config.seed, Stage::Transfer, 0);
    let scene = tracer.scene();
    watch.begin(TransferStage::Points, 1);
    let coarse = Patches::new(scene, &config.patches, &|_: Vec3| 1.0)?;
    let chosen = choose(tracer, &coarse, points, config, stream)?;
    if watch.halted() {
        return Err(TransferError::Halted);
    }
    let (sizes, patches) = if config.finer_patches > 0.0 {
        let used = met(tracer, &coarse, &chosen.even, stream)?;
        let (count, fixed) = (config.receiver_points, receiver_stream(config.seed));
        let receivers = Receivers::new(tracer, &coarse, count, Some(&used), fixed);
        let uneven = uneven(tracer, &coarse, &receivers, lights, stream.part(12));
        let sides = receivers.into_sides();
        finer_sizes(tracer, coarse, &sides, &uneven, config)?
    } else {
        let edge = Patches::edge(scene, &config.patches);
        (PatchSizes::even(edge), coarse)
    };
    let columns = ColumnTree::new(&patches);
    let pilot = some(&chosen.even, config.pilot_rows);
    let pilot_rows = trace_rows(tracer, &patches, &pilot, &config.paths, stream.part(4), 0)?;
    let mut used = pilot_rows.used();
    let met = met(tracer, &patches, &chosen.even, stream)?;
    used.iter_mut().zip(met).for_each(|(u, more)| *u |= more);
    let (count, fixed) = (config.receiver_points, receiver_stream(config.seed));
    let receivers = Receivers::new(tracer, &patches, count, Some(&used), fixed);
    let colour = |point: &RowPoint| tracer.material_at(&point.point).base_color;
    watch.begin(TransferStage::Lights, lights.len() as u64);
    let colours: Vec<Vec3> = pilot.iter().map(colour).collect();
    let lighting = Lighting::new(&receivers, lights, &pilot_rows, &colours, &columns, watch)?;
    let memory = MemoryNeed::new(&pilot_rows, &lighting, &columns, config, watch);
    drop(pilot_rows);
    let reflectances = Reflectances::new(tracer.scene(), config.paths.broad);
    let materials = tracer.scene().materials.iter();
    let metals: Vec<bool> = materials.map(|m| m.metallic > 0.5).collect();
    let mut rounds = Rounds {
        tracer: BatchTracer {
            tracer,
            patches: &patches,
            lighting: &lighting,
            reflectances: &reflectances,
            config,
        },
        metals: &metals,
        columns: &columns,
        streams: RoundStreams {
            rows: stream.part(6),
            more: stream.part(9),
            fits: stream,
            sketch: stream,
        },
        memory,
    };
    watch.begin(TransferStage::Cells, chosen.points.len() as u64);
    let batches = batches(tracer, chosen.points, config.rows_at_once);
    memory.check(batches.iter().map(Vec::len).max().unwrap_or(0))?;
    let width = columns.columns();
    let earlier = watch.resume(columns.len(), width)?;
    let mut done = (earlier.filter(|earlier| earlier.fits(width)))
        .unwrap_or_else(|| TransferProgress::new(width));
    for (number, points) in (0u32..).zip(batches) {
        let count = points.len() as u64;
        if number < done.batches {
            watch.advance(count);
            continue;
        }
        // rows are numbered in their batch: signs and fits have to know which it is
        let first = done.rows as u32;
        rounds.streams.sketch = stream.part(10).part(first);
        rounds.streams.fits = Stream::new(config.seed, Stage::Transfer, 1).part(first);
        let mut sketch = Sketch::of(width, std::mem::take(&mut done.sketch));
        let fits = rounds.fit(points, &mut done.rows, &mut sketch, watch)?;
        done.sketch = sketch.into_sums();
        for fit in fits.into_values() {
            done.append(&fit.tree, fit.cells);
        }
        done.batches += 1;
        watch.keep(&done)?;
        watch.advance(count);
    }
    let sketch = Sketch::of(width, done.sketch);
    let numbers = stream.part(11);
    let sketch = clustered(
        &sketch.read(),
        &columns,
        &lighting,
        SKETCH_ERROR,
        SKETCH_NODES,
        numbers,
    );
    Ok(TransferModel {
        receiver_points: count,
        seed: config.seed,
        broad: config.paths.broad,
        sketch,
        trust: config.trust,
        tree: done.tree,
        cells: done.cells,
        sizes,
        used,
        patch_config: config.patches,
        patches,
        columns,
        reflectances,
    })
}

/// About `count` of the points, evenly picked.
fn some(points: &[RowPoint], count: usize) -> Vec<RowPoint> {
    let step = points.len().div_ceil(count.max(1)).max(1);
    points.iter().step_by(step).copied().collect()
}

/// Points by surface, whole surfaces together, about `count` at a time.
fn batches(tracer: &Tracer, points: Vec<RowPoint>, count: usize) -> Vec<Vec<RowPoint>> {
    let mut surfaces: BTreeMap<SurfaceKey, Vec<RowPoint>> = BTreeMap::new();
    for point in points {
        let key = TransferQuery::of_row(tracer, &point).surface;
        surfaces.entry(key).or_default().push(point);
    }
    let mut batches: Vec<Vec<RowPoint>> = vec![Vec::new()];
    for own in surfaces.into_values() {
        match batches.last_mut() {
            Some(last) if last.is_empty() || last.len() + own.len() <= count => last.extend(own),
            _ => batches.push(own),
        }
    }
    batches
}
