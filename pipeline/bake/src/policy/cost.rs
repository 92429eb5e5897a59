//! Predicted time and memory of tasks. Plans and schedulers need a number before anything has run, and
//! the same number on every machine, so that plans do not depend on where they are made.
//!
//! Measured on one core of a 2-core AMD EPYC (AVX-512) with the Cornell box. Other scenes and machines
//! differ by a factor that is the same for all tasks of a kind.

use crate::plan::round::{CellPlan, DrawPlan, MAX_DRAW_ROWS, PartPlan};
use rrf_trace::Tracer;
use rrf_train::fit::spill;
use rrf_train::{ARCHITECTURES, Kind, Size, TrainConfig};

/// Seconds of one path among [`FEW`] triangles, the exponent of the number of triangles beyond these, and
/// the factor where caustics of flat glossy surfaces are traced too.
const PATH: f64 = 0.7e-6;
const FEW: f64 = 32.0;
const POWER: f64 = 0.185;
const MIRRORS: f64 = 1.7;
/// Cost of a row's candidates, in paths.
const CANDIDATES: f64 = 20.0;
/// Seconds for a row taken from another part.
const TAKEN_ROW: f64 = 2e-6;
/// Seconds for one row, iteration and squared weight of a fit.
const STEP: f64 = 1.1e-11;
/// Seconds for one row of irradiance probes, with all ridge parameters.
const PROBES_ROW: f64 = 7e-4;
/// Share of the allowed iterations that a fit takes, and one that starts from an earlier net.
const TAKEN: f64 = 0.6;
const TAKEN_WARM: f64 = 0.3;
/// Steps in which inputs and units are removed from a net, 24 to 44 for a cell of the Cornell box, and those
/// of a smaller net that is tried, with a quarter of the work each.
const PRUNE_STEPS: f64 = 56.0;
/// Weights of a net of unknown size.
const SOME_WEIGHTS: u64 = 500;
/// Maximum of inputs that vary in a cell: the normal or the material does not.
const VARYING_INPUTS: usize = 16;
/// Bytes of a row as it is drawn, traced and written.
const DRAWN_ROW: u64 = 600;
/// Bytes of a row as it is read and trained on.
const TRAINED_ROW: u64 = 900;
/// Bytes of a row of a part as it is read: the file, its columns, the table.
const READ_ROW: u64 = 300;
/// Bytes that a task needs whatever its rows, among them the matrices of nets of some 700 weights.
const BASE: u64 = 24 << 20;
/// Square matrices, with as many rows as the net has weights, that a fit holds: JᵀWJ, its factor, those kept
/// for further steps, and the same for a second initialization.
const MATRICES: u64 = 6;
/// [`BASE`] without these matrices.
const SMALL: u64 = 4 << 20;

/// Predicted seconds of one core for a path in a scene.
pub(crate) fn path_seconds(tracer: &Tracer) -> f64 {
    let triangles = tracer.scene().triangles.len() as f64;
    let mirrors = if tracer.has_mirrors() { MIRRORS } else { 1.0 };
    PATH * (triangles / FEW).max(1.0).powf(POWER) * mirrors
}

/// Predicted seconds of one core for a part; `path` as of [`path_seconds`].
pub(crate) fn extract_seconds(part: &PartPlan, draw: &DrawPlan, path: f64) -> f64 {
    match part.from {
        Some(_) => f64::from(draw.rows) * TAKEN_ROW,
        None => draw_seconds(draw.rows, draw.paths, path),
    }
}

/// Predicted seconds of one core to draw and trace `rows` rows of `paths` paths.
pub(crate) fn draw_seconds(rows: u32, paths: u32, path: f64) -> f64 {
    f64::from(rows) * (f64::from(paths) + CANDIDATES) * path
}

/// Upper bound of the memory of an extraction [bytes].
pub(crate) fn extract_memory(draw: &DrawPlan) -> u64 {
    BASE + u64::from(draw.rows) * DRAWN_ROW
}

/// Predicted seconds of one core for a cell's fit, compression included.
pub(crate) fn fit_seconds(rows: u64, cell: &CellPlan, config: &TrainConfig) -> f64 {
    match cell.prune {
        _ if config.kind == Kind::Probes => rows as f64 * PROBES_ROW,
        Some(_) => prune_seconds(rows, some_weights(&cell.size, config)),
        None => train_seconds(rows, &cell.size, config, cell.earlier.is_some()),
    }
}

/// Predicted seconds of one core to compress a net of so many weights.
pub(crate) fn prune_seconds(rows: u64, weights: u64) -> f64 {
    rows as f64 * PRUNE_STEPS * (weights * weights) as f64 * STEP
}

/// Predicted seconds of one core for a fit; `warm` where it starts from an earlier net.
pub(crate) fn train_seconds(rows: u64, size: &Size, config: &TrainConfig, warm: bool) -> f64 {
    let weights = some_weights(size, config) as f64;
    let iterations = config.iterations as f64 * if warm { TAKEN_WARM } else { TAKEN };
    rows as f64 * iterations * weights * weights * STEP
}

/// Weights of a net whose inputs are unknown.
fn some_weights(size: &Size, config: &TrainConfig) -> u64 {
    let inputs = config.inputs.len().min(VARYING_INPUTS);
    match size {
        Size::Hidden(hidden) => weights(inputs, hidden),
        // architectures are tried in turn until one meets the target: take the middle one
        Size::Smallest { .. } => ARCHITECTURES
            .get(ARCHITECTURES.len() / 2)
            .map_or(SOME_WEIGHTS, |hidden| weights(inputs, hidden)),
    }
}

fn weights(inputs: usize, hidden: &[usize]) -> u64 {
    let sizes = [&[inputs], hidden, &[3]].concat();
    sizes
        .iter()
        .zip(sizes.iter().skip(1))
        .map(|(below, above)| ((below + 1) * above) as u64)
        .sum()
}

/// Upper bound of the memory of a fit with its rows in memory [bytes].
pub(crate) fn train_memory(rows: u64, size: &Size, config: &TrainConfig) -> u64 {
    base(size, config) + rows * TRAINED_ROW
}

/// Upper bound of the memory of a fit with its rows in a file [bytes].
pub(crate) fn least_memory(rows: u64, size: &Size, config: &TrainConfig) -> u64 {
    let all = train_memory(rows, size, config);
    if config.kind == Kind::Nearest {
        return all;
    }
    // windows of the file and a part as it is read, then what every row keeps in memory
    let part = rows.min(u64::from(MAX_DRAW_ROWS)) * READ_ROW;
    let held = (part + rows * spill::ORDERED_ROW).max(rows * spill::HELD_ROW);
    all.min(base(size, config) + spill::WINDOWS + held)
}

/// Memory of a fit whatever its rows [bytes].
fn base(size: &Size, config: &TrainConfig) -> u64 {
    let weights = some_weights(size, config);
    let matrices = MATRICES * weights.saturating_mul(weights).saturating_mul(8);
    BASE.max(SMALL + matrices)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The base of every task covers a net of 20 and 10 units; the matrices of a wide one are added.
    #[test]
    fn wide_nets_need_room_for_their_matrices() {
        let config = TrainConfig::default();
        let memory = |hidden: &[usize]| train_memory(0, &Size::Hidden(hidden.to_vec()), &config);
        assert_eq!(memory(&[20, 10]), BASE);
        let weights = weights(VARYING_INPUTS, &[128, 128]);
        assert!(memory(&[128, 128]) >= 2 * weights * weights * 8);
        let least = least_memory(1 << 20, &Size::Hidden(vec![128, 128]), &config);
        assert!(least > memory(&[128, 128]));
    }
}
