//! Half estimates of accepted rows, and the seeds of their streams.

use crate::candidates::Accepted;
use crate::error::ExtractError;
use glam::Vec3;
use rrf_field::columns;
use rrf_trace::{Queries, Stream, Tracer, indirect};

/// Stage number of the plan's pilot.
pub(crate) const PILOT_STAGE: u32 = 3;

/// Two independent half estimates [W/(sr m^2)] of every accepted row.
pub(crate) fn trace_halves(
    tracer: &Tracer,
    accepted: &Accepted,
    paths: u32,
    stream: Stream,
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
    let estimates = indirect(tracer, queries, paths, 2, stream, 0)?;
    let half = |h: usize| {
        (0..estimates.len())
            .map(|q| estimates.halves(q)[h].to_array())
            .collect()
    };
    Ok([half(0), half(1)])
}

/// The seed of a stream's Sobol scramble.
pub(crate) fn scramble_seed(seed: u64, stream: u64) -> u64 {
    let mut z = seed ^ stream.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 33)).wrapping_mul(0xff51_afd7_ed55_8ccd);
    z = (z ^ (z >> 33)).wrapping_mul(0xc4ce_b9fe_1a85_ec53);
    z ^ (z >> 33)
}
