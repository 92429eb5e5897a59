//! Where patches have to be finer.
//!
//! A patch says one number of the light on it, and rows take it as even. That is wrong by what
//! the light varies over the patch times what a row's view of the patch varies over it. The first is
//! asked for: some lights of the ensemble at the points of coarse patches. The second is small
//! where everything is far away, and all of it where something stands as near as the patch is wide: in
//! gaps and at contacts. Patches for which the product is large are quartered again and again, the
//! worst first, as long as there may be more.

use super::config::TransferConfig;
use crate::TransferError;
use crate::irradiance::{Receivers, Side};
use crate::lights::DirectLight;
use crate::patches::{PatchSizes, Patches};
use crate::tracing::{DIMENSIONS, Hits, Rays, Scramble, Stream, Table, Tracer, scramble};
use rayon::prelude::*;
use rrf_lights::about;
use rrf_materials::cosine_hemisphere;
use rrf_sampling::sobol::scrambles;

/// Lights of a kind that are asked.
const OF_A_KIND: usize = 16;
/// Rays of a point that look for what is near.
const LOOKS: usize = 8;
/// Distances below this are alike, metres.
const NEAREST: f32 = 0.01;
/// Sides that are looked from together.
const BATCH: usize = 64;
/// A side that gets less than this share of what the mean side gets counts as if it got that.
const FLOOR: f32 = 0.02;
/// Patches whose edge is below the common one by this, in powers of two, are small.
const SMALL: f32 = 1.5;
/// Sizes that are tried until there are few enough patches.
const TRIALS: usize = 12;

/// A patch of which rows take the light as even.
pub(crate) struct Uneven {
    /// Deviation of the light over it, relative to its mean.
    varies: f32,
    /// Its edge over the distance of what is around it.
    near: f32,
}

impl Uneven {
    /// What it gets wrong after some quarterings: half of the variation is left at each, and once
    /// patches are narrower than their distance, half of the rows' too.
    fn error(&self, quarterings: u32) -> f32 {
        let by = 1.0 / (1u32 << quarterings) as f32;
        self.varies * by * (self.near * by).min(1.0)
    }

    /// The fewest quarterings that come below an error.
    fn quarterings(&self, error: f32) -> u32 {
        let most = u32::from(PatchSizes::MOST);
        (0..most).find(|&k| self.error(k) <= error).unwrap_or(most)
    }
}

/// Sizes for patches, from coarse ones and the points on them; those patches.
pub(crate) fn finer_sizes(
    tracer: &Tracer,
    coarse: Patches,
    receivers: &[Side],
    uneven: &[Uneven],
    config: &TransferConfig,
) -> Result<(PatchSizes, Patches), TransferError> {
    let scene = tracer.scene();
    let edge = Patches::edge(scene, &config.patches);
    let sizes = |error: f32| {
        let mut sizes = PatchSizes::even(edge);
        for (side, uneven) in receivers.iter().zip(uneven) {
            let own = (edge / coarse.area[side.patch as usize].sqrt()).log2();
            let quarterings = uneven.quarterings(error);
            // sizes hold for all surfaces at a place: small things do not ask for those around them
            if quarterings > 0 && own < SMALL {
                let level = (own.max(0.0) + quarterings as f32).round() as u8;
                let places = side.points.iter().map(|point| point.position);
                let centre = coarse.centre[side.patch as usize];
                places
                    .chain([centre])
                    .for_each(|at| sizes.demand(at, level));
            }
        }
        sizes
    };
    let most = (f64::from(config.finer_patches) * config.patches.count as f64) as usize;
    let mut error = config.patch_error;
    for _ in 0..TRIALS {
        let sizes = sizes(error);
        let patches = Patches::new(scene, &config.patches, &sizes.field())?;
        if patches.len() <= coarse.len() + most {
            return Ok((sizes, patches));
        }
        let ratio = (patches.len() - coarse.len()) as f32 / most.max(1) as f32;
        error *= ratio.sqrt().clamp(1.1, 2.0);
    }
    Ok((PatchSizes::even(edge), coarse))
}

/// What rows take as even on each side.
pub(crate) fn uneven(
    tracer: &Tracer,
    coarse: &Patches,
    receivers: &Receivers,
    lights: &[&dyn DirectLight],
    stream: Stream,
) -> Vec<Uneven> {
    let sides = receivers.each();
    let asked = of_each_kind(lights);
    let mut varies = vec![0.0f32; sides.len()];
    for spread in asked.iter().map(|light| receivers.spreads(*light)) {
        let lit = spread.iter().filter(|s| s[0] > 0.0);
        let (sum, count) = lit.fold((0.0, 0), |(sum, n), s| (sum + s[0], n + 1));
        let least = FLOOR * sum / count.max(1) as f32;
        for (varies, [mean, variance]) in varies.iter_mut().zip(spread) {
            if mean > 0.0 {
                *varies += variance / mean.max(least).powi(2) / asked.len() as f32;
            }
        }
    }
    let distances = distances(tracer, sides, stream);
    (sides.iter().zip(&varies).zip(distances))
        .map(|((side, varies), distance)| Uneven {
            varies: varies.sqrt(),
            near: coarse.area[side.patch as usize].sqrt() / distance,
        })
        .collect()
}

/// Some lights of each kind: points, lamps, and what comes from afar.
fn of_each_kind<'a>(lights: &[&'a dyn DirectLight]) -> Vec<&'a dyn DirectLight> {
    let kind = |light: &dyn DirectLight| match light.bounds() {
        Some([low, high]) if low == high => 0,
        Some(_) => 1,
        None => 2,
    };
    let mut kinds: [Vec<&dyn DirectLight>; 3] = Default::default();
    lights
        .iter()
        .for_each(|&light| kinds[kind(light)].push(light));
    let some = kinds.into_iter().flat_map(|own| {
        let count = own.len().min(OF_A_KIND);
        // the last of each: a scene's own lights stand behind those that are drawn
        (1..=count).map(move |k| own[k * own.len() / count - 1])
    });
    some.collect()
}

/// The harmonic mean of the distances of what is around each side.
fn distances(tracer: &Tracer, sides: &[Side], stream: Stream) -> Vec<f32> {
    let table = Table::new(LOOKS);
    let batches = sides.par_chunks(BATCH).map(|sides| {
        let (mut rays, mut hits) = (Rays::default(), Hits::default());
        for side in sides {
            let owner = u64::from(side.patch) * 2 + u64::from(side.back);
            for (k, (point, &triangle)) in side.points.iter().zip(&side.triangles).enumerate() {
                let by: [Scramble; DIMENSIONS] = scrambles(stream, owner, k as u32);
                for look in 0..LOOKS {
                    let u = table.reversed(look);
                    let u = [0, 1].map(|d: usize| scramble(u[d], by[d]));
                    let toward = about(point.geometric, cosine_hemisphere(u));
                    let origin = tracer.lift(triangle, point.position, toward);
                    rays.push(origin, toward, f32::INFINITY);
                }
            }
        }
        tracer.closest(&rays, &mut hits);
        let mut at = 0;
        let distance = |side: &Side| {
            let count = side.points.len() * LOOKS;
            let met = at..at + count;
            at += count;
            let sum: f32 = met
                .filter(|&i| hits.triangle[i] != rrf_scene::INVALID)
                .map(|i| 1.0 / hits.t[i].max(NEAREST))
                .sum();
            count as f32 / sum.max(f32::MIN_POSITIVE)
        };
        sides.iter().map(distance).collect::<Vec<f32>>()
    });
    batches.flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fewer quarterings where more error is allowed, and none where it is small.
    #[test]
    fn quarterings_follow_the_error() {
        let open = Uneven {
            varies: 0.5,
            near: 0.1,
        };
        let gap = Uneven {
            varies: 1.5,
            near: 4.0,
        };
        assert_eq!(open.quarterings(0.06), 0);
        // 1.5 / 8 by half of what rows see of it
        assert_eq!(gap.error(3), 1.5 / 8.0 * 0.5);
        assert_eq!(
            [0.1, 0.4, 2.0].map(|error| gap.quarterings(error)),
            [3, 2, 0]
        );
    }
}
