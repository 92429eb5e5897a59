//! The plan: the first tree, and how many rows each of its cells gets.

use crate::candidates::{Accepted, Proposal, accept};
use crate::census::Census;
use crate::config::ExtractConfig;
use crate::error::ExtractError;
use crate::eyes::Eyes;
use crate::first_tree::grow;
use crate::halves::trace_halves;
use crate::visibility::VisibilityQueries;
use rrf_field::tree::{Domain, Tree};
use rrf_sampling::hash::sequence_seed;
use rrf_sampling::{Stage, Stream};
use rrf_scene::Scene;
use rrf_trace::Tracer;

/// A cell's share of the work.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellShare {
    /// Rows to extract.
    pub rows: u32,
    /// Share of all valid (point, view, light) combinations that lie in the cell, summing to 1:
    /// the cell's weight in a mean over the whole scene.
    pub measure: f64,
}

/// The first extraction: its tree and the rows of its cells.
#[derive(Clone, Debug, PartialEq)]
pub struct FirstPlan {
    /// Which cell a row belongs to.
    pub tree: Tree,
    /// The cells, by id.
    pub cells: Vec<CellShare>,
    /// Which materials of the scene look the same from everywhere, by material id.
    pub lambert: Vec<bool>,
    /// Mean luminance (mean of r, g, b) of the indirect radiance over all valid combinations,
    /// W/(sr m^2), estimated at the candidates.
    pub mean_luminance: f32,
    /// Candidates accepted and left out over the whole scene.
    pub census: Census,
}

/// Stream of the candidates that the plan is made from; draws use `stream + 1`.
const WHOLE_SCENE: u64 = 0;
/// Paths that each candidate's radiance is estimated by: noise averages out over all of them.
const PILOT_PATHS: u32 = 4;
/// Candidates drawn for each one wanted before a plan gives up.
const PATIENCE: usize = 64;

/// Draws candidates over the whole scene and grows the first tree.
pub fn plan(
    scene: &Scene,
    tracer: &Tracer,
    config: &ExtractConfig,
) -> Result<FirstPlan, ExtractError> {
    let bounds = scene.bounds().ok_or(ExtractError::NoTriangle)?;
    config.validate(&bounds)?;
    let seed = sequence_seed(config.seed, WHOLE_SCENE);
    let nothing = |census: Census| ExtractError::NoRow {
        drawn: u64::from(config.candidates) * PATIENCE as u64,
        census,
    };
    let visibility = VisibilityQueries::new(scene, tracer);
    let eyes = config
        .eye_box
        .map(|eye_box| Eyes::new(&visibility, eye_box))
        .transpose()?;
    let proposal = Proposal::new(
        scene,
        tracer,
        &visibility,
        Domain::ALL,
        config.light_box,
        seed,
    )
    .ok_or_else(|| nothing(Census::default()))?
    .seen_by(eyes.as_ref())
    .without_traced(config.narrow);
    let drawn = accept(&proposal, config.candidates as usize, PATIENCE);
    tracer.unless_halted(())?;
    if drawn.rows.is_empty() {
        return Err(nothing(drawn.census));
    }
    let diagonal = bounds.diagonal();
    let fewest = (drawn.rows.len() / (config.cells as usize * 16)).max(8);
    let tree = grow(&drawn.rows, diagonal, config.weights, config.cells, fewest);
    let mut counts = vec![0u64; tree.cells()];
    tree.find_all(&drawn.rows)
        .iter()
        .for_each(|&c| counts[c as usize] += 1);
    let lambert = scene
        .materials
        .iter()
        .map(|m| !m.kind.depends_on_viewer)
        .collect();
    Ok(FirstPlan {
        cells: share_out(&counts, config),
        tree,
        lambert,
        mean_luminance: mean_luminance(tracer, &drawn, config)?,
        census: drawn.census,
    })
}

/// The pilot: what a row is worth on average, which decides below which luminance errors count
/// absolutely (ε).
fn mean_luminance(
    tracer: &Tracer,
    drawn: &Accepted,
    config: &ExtractConfig,
) -> Result<f32, ExtractError> {
    let stream = Stream::new(config.seed, Stage::Pilot, 0);
    let halves = trace_halves(tracer, drawn, (PILOT_PATHS, config.narrow), stream)?;
    let sum: f64 = halves
        .iter()
        .flatten()
        .map(|y| f64::from(y[0] + y[1] + y[2]) / 3.0)
        .sum();
    Ok((sum / (halves[0].len() + halves[1].len()).max(1) as f64) as f32)
}

/// Rows go with the square root of a cell's measure: a small cell's net needs as many rows
/// as a large one's, a large cell is seen more.
fn share_out(counts: &[u64], config: &ExtractConfig) -> Vec<CellShare> {
    let total: u64 = counts.iter().sum();
    let measure = |n: u64| n as f64 / total as f64;
    let roots: f64 = counts.iter().map(|&n| measure(n).sqrt()).sum();
    let share = |n: u64| (f64::from(config.rows) * measure(n).sqrt() / roots).round() as u32;
    counts
        .iter()
        .map(|&n| CellShare {
            rows: share(n).max(config.fewest_rows),
            measure: measure(n),
        })
        .collect()
}
