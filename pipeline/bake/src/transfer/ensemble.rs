//! The lights that a transfer is fitted to and judged by.

use super::config::TransferBakeConfig;
use super::space::FreeSpace;
use crate::error::BakeError;
use glam::Vec3;
use rrf_extract::{ExtractError, Region};
use rrf_sampling::{Stage, Stream};
use rrf_scene::Scene;
use rrf_trace::Tracer;
use rrf_transfer::{ConditionPlan, LightConditions};

/// One point light of so many lies anywhere in free space where there is a light box.
const ELSEWHERE: usize = 5;

/// The stream that lights of the ensemble sample by.
pub(super) fn light_stream(seed: u64) -> Stream {
    Stream::new(seed, Stage::Transfer, 5)
}

/// Points in the light box and beyond it, suns and skies, each one light; as many as the settings say,
/// drawn by a stream.
///
/// # Errors
/// [`BakeError::Extract`] for a light box without a free place.
pub(super) fn conditions(
    scene: &Scene,
    tracer: &Tracer,
    space: &FreeSpace,
    config: &TransferBakeConfig,
    stream: Stream,
) -> Result<LightConditions, BakeError> {
    let bounds = scene.bounds().ok_or(ExtractError::NoTriangle)?;
    let whole = [Vec3::from(bounds.min), Vec3::from(bounds.max)];
    let free = |place: Vec3| space.is_free(place);
    let mut plan = ConditionPlan {
        points: config.points,
        suns: config.suns,
        skies: config.skies,
        ..ConditionPlan::within(whole)
    };
    let Some(Region { minimum, maximum }) = config.light_box else {
        return Ok(LightConditions::new(tracer, &free, &plan, stream.part(1)));
    };
    plan.points = config.points / ELSEWHERE;
    let mut all = LightConditions::new(tracer, &free, &plan, stream.part(1));
    let boxed = ConditionPlan {
        within: [minimum.into(), maximum.into()],
        points: config.points - plan.points,
        suns: 0,
        skies: 0,
        ..plan
    };
    let boxed = LightConditions::new(tracer, &free, &boxed, stream.part(2));
    if boxed.sources.is_empty() {
        return Err(ExtractError::Box {
            what: "light",
            bounds: Region { minimum, maximum },
            message: "has no place in the free space that eyes are in".into(),
        }
        .into());
    }
    all.sources.extend(boxed.sources);
    Ok(all)
}
