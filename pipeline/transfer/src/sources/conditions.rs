//! The ensemble of light conditions that a basis is made for.
//!
//! Each condition counts alike in the basis, whatever its brightness
//! ([`crate::RelativeWeights`]), so the counts are the weights: by default 200 points, and where
//! the sky is seen 64 suns and 16 smooth skies, beside the scene's own lights one by one.
//!
//! - Points are uniform in the free part of a box: the light box where there is one, else the
//!   scene's own.
//! - A sun stands in a direction in which some free place of that box sees out of the scene:
//!   a sun that lights nothing teaches nothing.
//! - A smooth sky is a lobe of such suns about one of them.

use super::source::SourceLight;
use crate::tracing::{Rays, Stream, Tracer};
use glam::Vec3;
use rrf_lights::{DistantLight, LightSource, PointLight, uniform_sphere};

/// Directions that are tried for suns.
const TRIED: u32 = 1024;
/// Free places that look for the sky.
const LOOKING: usize = 256;
/// Draws of a place for one that is wanted, before it is given up.
const DRAWS: u64 = 200;
/// Suns of a smooth sky.
const SUNS_OF_SKY: usize = 12;
/// Sharpness of a smooth sky's lobe: exp(sharpness (cos - 1)).
const LOBE: f32 = 3.0;

/// How many conditions of each kind are drawn, and where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConditionPlan {
    /// Least and greatest corner of the box that points are drawn in, world frame, metres.
    pub within: [Vec3; 2],
    /// Isotropic points.
    pub points: usize,
    /// Suns; none where no sky is seen.
    pub suns: usize,
    /// Smooth skies; none where no sky is seen.
    pub skies: usize,
    /// Points are at least this far from surfaces, metres.
    pub clearance: f32,
}

impl ConditionPlan {
    /// The default counts in a box.
    pub fn within(within: [Vec3; 2]) -> ConditionPlan {
        ConditionPlan {
            within,
            points: 200,
            suns: 64,
            skies: 16,
            clearance: 0.0,
        }
    }
}

/// Lights as an ensemble has them: each a group that shines at once.
#[derive(Clone, Debug, Default)]
pub struct LightConditions {
    /// Sources of each condition.
    pub sources: Vec<Vec<LightSource>>,
    /// Share of the tried directions in which the sky is seen.
    pub sky_seen: f32,
}

impl LightConditions {
    /// Draws the conditions; `is_free` tells where lights may be. A plan whose box has no free
    /// place has no points, and no suns.
    pub fn new(
        tracer: &Tracer,
        is_free: &dyn Fn(Vec3) -> bool,
        plan: &ConditionPlan,
        stream: Stream,
    ) -> LightConditions {
        let free = |count: usize, clearance: f32, part: u32| {
            let stream = stream.part(part);
            let wanted = |place: Vec3| {
                is_free(place) && (clearance <= 0.0 || tracer.distance(place, clearance).is_none())
            };
            (0..count as u64 * DRAWS)
                .map(|i| within(plan.within, stream.units(i, 0, 0)))
                .filter(|&place| wanted(place))
                .take(count)
                .collect::<Vec<Vec3>>()
        };
        let points = free(plan.points, plan.clearance, 0);
        let mut sources: Vec<Vec<LightSource>> = (points.into_iter())
            .map(|position| {
                let intensity = Vec3::ONE;
                vec![
                    PointLight {
                        position,
                        intensity,
                    }
                    .into(),
                ]
            })
            .collect();
        let seen = if plan.suns + plan.skies > 0 {
            sky_seen(tracer, &free(LOOKING, 0.0, 1), stream.part(2))
        } else {
            Vec::new()
        };
        sources.extend(evenly(&seen, plan.suns).map(|toward| vec![sun(toward, 1.0)]));
        sources.extend(evenly(&seen, plan.skies).map(|axis| smooth_sky(axis, &seen)));
        LightConditions {
            sources,
            sky_seen: seen.len() as f32 / TRIED as f32,
        }
    }

    /// The conditions as direct light.
    pub fn lights(&self, stream: Stream) -> Vec<Vec<SourceLight<'_>>> {
        let light = |source| SourceLight::new(source, stream);
        (self.sources.iter())
            .map(|group| group.iter().map(light).collect())
            .collect()
    }
}

/// Directions in which at least one of the places sees out of the scene, in an order in which
/// neighbours are near.
fn sky_seen(tracer: &Tracer, places: &[Vec3], stream: Stream) -> Vec<Vec3> {
    let (mut rays, mut blocked) = (Rays::default(), Vec::new());
    (0..TRIED)
        .filter_map(|i| {
            // strata: bands of equal height, and the golden angle about the axis
            let u = stream.units(u64::from(i), 0, 0);
            let height = (i as f32 + u[0]) / TRIED as f32;
            let turn = (0.618_034 * i as f32 + u[1] / (TRIED as f32).sqrt()).fract();
            let toward = uniform_sphere([height, turn]);
            let toward = Vec3::new(toward.x, toward.z, toward.y);
            rays.clear();
            places
                .iter()
                .for_each(|&p| rays.push(p, toward, f32::INFINITY));
            tracer.occluded(&rays, &mut blocked);
            blocked.contains(&false).then_some(toward)
        })
        .collect()
}

/// `count` of the directions, evenly picked.
fn evenly(seen: &[Vec3], count: usize) -> impl Iterator<Item = Vec3> + '_ {
    let count = count.min(seen.len());
    (0..count).map(move |k| seen[k * seen.len() / count.max(1)])
}

fn sun(toward: Vec3, irradiance: f32) -> LightSource {
    DistantLight::sun(toward, Vec3::splat(irradiance)).into()
}

/// A lobe about an axis, of suns spread over what is seen of the sky.
fn smooth_sky(axis: Vec3, seen: &[Vec3]) -> Vec<LightSource> {
    let weight = |toward: Vec3| (LOBE * (toward.dot(axis) - 1.0)).exp();
    evenly(seen, SUNS_OF_SKY)
        .map(|toward| sun(toward, weight(toward)))
        .collect()
}

fn within([low, high]: [Vec3; 2], u: [f32; 4]) -> Vec3 {
    low + (high - low) * Vec3::new(u[0], u[1], u[2])
}
