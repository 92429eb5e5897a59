//! Half estimates of accepted rows.

use crate::candidates::Accepted;
use crate::config::NarrowLight;
use crate::error::ExtractError;
use glam::Vec3;
use rrf_field::columns;
use rrf_sampling::Stream;
use rrf_trace::{Queries, Sampling, Tracer, broad_indirect, indirect};

/// Two independent half estimates [W/(sr m^2)] of every accepted row, by so many paths.
pub(crate) fn trace_halves(
    tracer: &Tracer,
    accepted: &Accepted,
    (paths, narrow): (u32, NarrowLight),
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
    let sampling = Sampling {
        paths,
        replicates: 2,
    };
    let estimates = match narrow {
        NarrowLight::Learned => indirect(tracer, queries, paths, 2, stream, 0)?,
        NarrowLight::Traced => broad_indirect(tracer, queries, sampling, stream, 0)?,
    };
    let half = |h: usize| {
        (0..estimates.len())
            .map(|q| estimates.halves(q)[h].to_array())
            .collect()
    };
    Ok([half(0), half(1)])
}
