//! One cell's rows, path-traced.

use crate::candidates::{Accepted, Proposal, accept};
use crate::config::{Census, ExtractConfig, ExtractError};
use crate::outlook::Lookout;
use crate::planning::{CellPlan, cell_seed};
use glam::Vec3;
use rrf_field::columns;
use rrf_field::tree::Domain;
use rrf_scene::Scene;
use rrf_store::samples::SampleTable;
use rrf_trace::{Queries, Stream, Tracer, indirect};

/// Stage number of extraction in every [`Stream`].
pub const STAGE: u32 = 1;
/// Candidates drawn for each row wanted before a cell makes do with fewer rows.
const PATIENCE: usize = 4096;
/// First numbers of the Sobol streams of cells; the plan's own stream is 0.
const FIRST_CELL_STREAM: u64 = 1;

/// A cell's table and what was left out on the way to it.
#[derive(Clone, Debug)]
pub struct ExtractedCell {
    /// Rows with two half estimates each.
    pub table: SampleTable,
    /// Candidates accepted and left out.
    pub census: Census,
}

/// Draws and traces the rows that `plan` wants of one cell with this domain.
pub fn extract_cell(
    scene: &Scene,
    tracer: &Tracer,
    lookout: &Lookout,
    domain: Domain,
    plan: CellPlan,
    config: &ExtractConfig,
) -> Result<ExtractedCell, ExtractError> {
    let seed = cell_seed(config.seed, u64::from(plan.cell) + FIRST_CELL_STREAM);
    let accepted = Proposal::new(scene, tracer, lookout, domain, config.light_box, seed)
        .map(|proposal| accept(&proposal, plan.rows as usize, PATIENCE))
        .unwrap_or_default();
    let halves = trace_halves(tracer, &accepted, plan.cell, config)?;
    let rows = accepted.index.len();
    Ok(ExtractedCell {
        census: accepted.census,
        table: SampleTable {
            cell_id: plan.cell,
            index: accepted.index,
            columns: accepted.rows,
            material: accepted.material,
            halves,
            paths: vec![config.paths; rows],
        },
    })
}

/// Two independent half estimates [W/(sr m^2)] of every accepted row.
fn trace_halves(
    tracer: &Tracer,
    accepted: &Accepted,
    cell: u32,
    config: &ExtractConfig,
) -> Result<[Vec<[f32; 3]>; 2], ExtractError> {
    let column = |first| -> Vec<Vec3> {
        (0..accepted.rows.len())
            .map(|r| accepted.rows.vec3(first, r).into())
            .collect()
    };
    let (viewers, lights) = (column(columns::V), column(columns::L));
    let queries = Queries {
        points: &accepted.surface,
        viewers: &viewers,
        lights: &lights,
    };
    let stream = Stream::new(config.seed, STAGE, cell);
    let estimates = indirect(tracer, queries, config.paths, 2, stream, 0)?;
    let half = |h: usize| {
        (0..estimates.len())
            .map(|q| estimates.halves(q)[h].to_array())
            .collect()
    };
    Ok([half(0), half(1)])
}
