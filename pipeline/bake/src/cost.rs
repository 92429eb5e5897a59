//! What tasks should cost: plans and schedulers need a number before anything has run, and the
//! same number on every machine, so that plans do not depend on where they are made.
//!
//! Measured on one core of a 2-core AMD EPYC (AVX-512) with the Cornell box; other scenes and
//! machines differ by a factor that is the same for all tasks of a stage.

use crate::plan::{DrawPlan, MOST_ROWS, PartPlan};
use rrf_train::{LADDER, Size, TrainConfig, spill};

/// Seconds a path of extraction.
const PATH: f64 = 0.6e-6;
/// Seconds a row taken from another part.
const TAKEN_ROW: f64 = 2e-6;
/// Seconds a row, iteration and squared weight of a fit.
const STEP: f64 = 1.2e-11;
/// Weights of a net that is not known yet.
const SOME_WEIGHTS: u64 = 500;
/// Inputs that vary in a cell, at the most: the normal or the material does not.
const VARYING_INPUTS: usize = 16;
/// Bytes of a row as it is drawn, traced and written.
const DRAWN_ROW: u64 = 600;
/// Bytes of a row as it is read and trained on.
const TRAINED_ROW: u64 = 500;
/// Bytes of a row of a part as it is read: the file, its columns, the table.
const READ_ROW: u64 = 300;
/// Bytes that a task needs whatever its rows.
const BASE: u64 = 24 << 20;

/// Seconds of one core.
pub(crate) fn extract_seconds(part: &PartPlan, draw: &DrawPlan) -> f64 {
    let rows = f64::from(draw.rows);
    match part.from {
        Some(_) => rows * TAKEN_ROW,
        None => draw_seconds(draw.rows, draw.paths),
    }
}

/// Seconds of one core that `rows` rows of `paths` paths take to trace.
pub(crate) fn draw_seconds(rows: u32, paths: u32) -> f64 {
    f64::from(rows) * f64::from(paths) * PATH
}

/// Bytes at the most.
pub(crate) fn extract_memory(draw: &DrawPlan) -> u64 {
    BASE + u64::from(draw.rows) * DRAWN_ROW
}

/// Seconds of one core.
pub(crate) fn train_seconds(rows: u64, size: &Size, config: &TrainConfig) -> f64 {
    let inputs = config.inputs.len().min(VARYING_INPUTS);
    let weights = match size {
        Size::Hidden(hidden) => weights(inputs, hidden),
        // the ladder is climbed until the target is reached: the middle
        Size::Smallest { .. } => LADDER
            .get(LADDER.len() / 2)
            .map_or(SOME_WEIGHTS, |hidden| weights(inputs, hidden)),
    } as f64;
    rows as f64 * config.iterations as f64 * weights * weights * STEP
}

fn weights(inputs: usize, hidden: &[usize]) -> u64 {
    let sizes = [&[inputs], hidden, &[3]].concat();
    sizes
        .iter()
        .zip(sizes.iter().skip(1))
        .map(|(below, above)| ((below + 1) * above) as u64)
        .sum()
}

/// Bytes at the most.
pub(crate) fn train_memory(rows: u64) -> u64 {
    BASE + rows * TRAINED_ROW
}

/// The same with the rows in a file: a part as it is read, windows of the file, and what stays in
/// memory of every row.
pub(crate) fn spilled_memory(rows: u64) -> u64 {
    let part = rows.min(u64::from(MOST_ROWS)) * READ_ROW;
    train_memory(rows).min(BASE + part + spill::WINDOWS + rows * spill::HELD_ROW)
}
