//! The plan: the first tree, and how many rows each of its cells gets.

use crate::candidates::{Proposal, accept};
use crate::config::{Census, ExtractConfig, ExtractError};
use crate::first_tree::grow;
use crate::outlook::Lookout;
use rrf_field::tree::{Domain, Tree};
use rrf_scene::{MaterialKind, Scene};
use rrf_trace::Tracer;
use serde::{Deserialize, Serialize};

/// A cell's share of the work.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CellPlan {
    /// The cell.
    pub cell: u32,
    /// Rows to extract.
    pub rows: u32,
    /// Share of all valid (point, view, light) combinations that lie in the cell, summing to 1:
    /// the cell's weight in a mean over the whole scene.
    pub measure: f64,
}

/// What is to be extracted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Which cell a row belongs to.
    pub tree: Tree,
    /// The cells, by id.
    pub cells: Vec<CellPlan>,
    /// Which materials of the scene are Lambertian, by material id.
    pub lambert: Vec<bool>,
    /// Candidates accepted and left out over the whole scene.
    pub census: Census,
}

impl Plan {
    /// Whether tree and cells belong together.
    pub fn check(&self) -> Result<(), String> {
        self.tree.check()?;
        if self.cells.len() != self.tree.cells() {
            return Err(format!(
                "{} cells, but {} leaves",
                self.cells.len(),
                self.tree.cells()
            ));
        }
        let wrong = (0u32..)
            .zip(&self.cells)
            .find(|(id, c)| c.cell != *id || !c.measure.is_finite());
        wrong.map_or(Ok(()), |(id, _)| {
            Err(format!("cell {id}: id or measure is wrong"))
        })
    }
}

/// Stream of the candidates that the plan is made from; cells use `cell + 1`.
const WHOLE_SCENE: u64 = 0;
/// Candidates drawn for each one wanted before a plan gives up.
const PATIENCE: usize = 16;

/// Draws candidates over the whole scene and grows the first tree.
pub fn plan(scene: &Scene, tracer: &Tracer, config: &ExtractConfig) -> Result<Plan, ExtractError> {
    let bounds = scene.bounds().ok_or(ExtractError::NoTriangle)?;
    config.validate(&bounds)?;
    let seed = cell_seed(config.seed, WHOLE_SCENE);
    let nothing = |census: Census| ExtractError::NoRow {
        drawn: u64::from(config.candidates) * PATIENCE as u64,
        census,
    };
    let lookout = Lookout::new(scene, tracer);
    let proposal = Proposal::new(scene, tracer, &lookout, Domain::ALL, config.light_box, seed)
        .ok_or_else(|| nothing(Census::default()))?;
    let drawn = accept(&proposal, config.candidates as usize, PATIENCE);
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
        .map(|m| m.kind == MaterialKind::Lambert)
        .collect();
    Ok(Plan {
        cells: share_out(&counts, config),
        tree,
        lambert,
        census: drawn.census,
    })
}

/// Rows go with the square root of a cell's measure: a small cell's net needs as many rows
/// as a large one's, a large cell is seen more.
fn share_out(counts: &[u64], config: &ExtractConfig) -> Vec<CellPlan> {
    let total: u64 = counts.iter().sum();
    let measure = |n: u64| n as f64 / total as f64;
    let roots: f64 = counts.iter().map(|&n| measure(n).sqrt()).sum();
    let share = |n: u64| (f64::from(config.rows) * measure(n).sqrt() / roots).round() as u32;
    (0u32..)
        .zip(counts)
        .map(|(cell, &n)| CellPlan {
            cell,
            rows: share(n).max(config.fewest_rows),
            measure: measure(n),
        })
        .collect()
}

/// The seed of a cell's Sobol scramble.
pub(crate) fn cell_seed(seed: u64, stream: u64) -> u64 {
    let mut z = seed ^ stream.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 33)).wrapping_mul(0xff51_afd7_ed55_8ccd);
    z = (z ^ (z >> 33)).wrapping_mul(0xc4ce_b9fe_1a85_ec53);
    z ^ (z >> 33)
}
