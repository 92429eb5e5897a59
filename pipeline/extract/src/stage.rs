//! One draw of rows, path-traced.

use crate::candidates::{Proposal, accept};
use crate::census::Census;
use crate::config::NarrowLight;
use crate::error::ExtractError;
use crate::eyes::Eyes;
use crate::halves::trace_halves;
use crate::region::Region;
use crate::visibility::VisibilityQueries;
use rrf_field::columns::Columns;
use rrf_field::tree::Domain;
use rrf_sampling::hash::sequence_seed;
use rrf_sampling::{Stage, Stream};
use rrf_scene::Scene;
use rrf_trace::Tracer;

/// Candidates drawn for each row wanted before a draw makes do with fewer rows.
const PATIENCE: usize = 4096;
/// First numbers of the Sobol streams of draws; the plan's own stream is 0.
const FIRST_STREAM: u64 = 1;

/// A request for rows inside a box of raw columns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Draw {
    /// Which draw of the run this is: fixes every random number of its rows.
    pub stream: u32,
    /// Where the rows lie.
    pub domain: Domain,
    /// Rows wanted.
    pub rows: u32,
    /// Paths a row, even: half go to each half estimate.
    pub paths: u32,
    /// Treatment of narrow parts' light.
    pub narrow: NarrowLight,
}

/// Rows drawn and traced, and what was left out on the way to them.
#[derive(Clone, Debug, Default)]
pub struct Drawn {
    /// Index of each row in the run: the draw's stream times 2^32, plus the candidate.
    pub index: Vec<u64>,
    /// Raw columns.
    pub rows: Columns,
    /// Material ids.
    pub material: Vec<u32>,
    /// Two independent half estimates [W/(sr m^2)] of each row.
    pub halves: [Vec<[f32; 3]>; 2],
    /// Candidates accepted and left out.
    pub census: Census,
}

/// Draws rows and traces them.
pub fn extract(
    scene: &Scene,
    tracer: &Tracer,
    visibility: &VisibilityQueries,
    eyes: Option<&Eyes>,
    light_box: Region,
    seed: u64,
    draw: &Draw,
) -> Result<Drawn, ExtractError> {
    let scramble = sequence_seed(seed, u64::from(draw.stream) + FIRST_STREAM);
    let accepted = Proposal::new(scene, tracer, visibility, draw.domain, light_box, scramble)
        .map(|proposal| proposal.seen_by(eyes).without_traced(draw.narrow))
        .map(|proposal| accept(&proposal, draw.rows as usize, PATIENCE))
        .unwrap_or_default();
    let stream = Stream::new(seed, Stage::Extract, draw.stream);
    let halves = trace_halves(tracer, &accepted, (draw.paths, draw.narrow), stream)?;
    let first = u64::from(draw.stream) << 32;
    Ok(Drawn {
        index: accepted.index.iter().map(|k| first + k).collect(),
        rows: accepted.rows,
        material: accepted.material,
        halves,
        census: accepted.census,
    })
}
