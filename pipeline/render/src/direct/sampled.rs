//! Direct light by sampling the lights: the plain uniform estimator, and one that learns.
//!
//! Learning follows Donikian, Walter, Bala, Fernandez, Greenberg, *Accurate Direct Illumination
//! Using Iterative Adaptive Sampling*, IEEE TVCG 12(3), 2006. Shadow rays go out in iterations.
//! After each, every block of 8 x 8 pixels and every pixel know what its rays found from which
//! light; the next rays choose lights by a mixture of three distributions, uniform, the block's
//! and the pixel's. The uniform share never vanishes, so a light that was missed so far is still
//! found, and no ray weighs more than the lights' number over that share.
//!
//! Unbiased: given what earlier iterations found, each iteration's mean is; iterations are
//! added with weights fixed beforehand. (Weights by the variance found would not be.)

use super::emitter::Emitter;
use super::light_choice::{LightChoice, ShadowRay};
use crate::tile::VisiblePoints;
use crate::timings::{FrameStage, Stopwatch};
use glam::Vec3;
use rrf_sampling::{Stage, Stream};
use rrf_trace::{Rays, Tracer};

/// Shadow rays of a pixel and iteration.
const ROUND: u32 = 4;

/// Number and choice of shadow rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShadowRays {
    /// Shadow rays of each camera ray.
    pub count: u32,
    /// Whether they learn from one another; otherwise lights are chosen uniformly.
    pub adaptive: bool,
    /// Seed of the random numbers.
    pub seed: u64,
}

impl Default for ShadowRays {
    fn default() -> ShadowRays {
        ShadowRays {
            count: 16,
            adaptive: true,
            seed: 1,
        }
    }
}

/// Working columns, made once a thread.
#[derive(Clone, Debug, Default)]
pub struct SampledLighting {
    /// Radiance [W·sr⁻¹·m⁻²] of each visible point after [`SampledLighting::shade`].
    pub radiance: Vec<Vec3>,
    rays: Rays,
    blocked: Vec<bool>,
    arriving: Vec<ShadowRay>,
    learned: LightChoice,
}

impl SampledLighting {
    /// Estimates the light that each visible point sends to its viewer straight from `lights`, with
    /// `plan.count` shadow rays. `first` is the number of the band's first pixel in the picture,
    /// `width` the picture's: random numbers belong to pixels.
    pub fn shade(
        &mut self,
        tracer: &Tracer,
        seen: &VisiblePoints,
        lights: &[Emitter],
        plan: ShadowRays,
        (first, width): (u64, u32),
        watch: &mut Stopwatch,
    ) {
        self.radiance.clear();
        self.radiance.resize(seen.points.len(), Vec3::ZERO);
        if lights.is_empty() || plan.count == 0 {
            return;
        }
        let rounds = rounds(plan);
        let weights: f32 = rounds.iter().map(|round| round.weight).sum();
        self.learned.begin(seen, lights.len(), plan.count, width);
        let stream = Stream::new(plan.seed, Stage::Direct, 0);
        for (number, round) in (0..).zip(&rounds) {
            self.aim(tracer, seen, lights, stream, (number, *round), first);
            watch.end(FrameStage::Direct);
            tracer.occluded(&self.rays, &mut self.blocked);
            watch.end(FrameStage::ShadowRays);
            let share = round.weight / weights / round.rays as f32;
            for (arriving, &blocked) in self.arriving.iter().zip(&self.blocked) {
                if !blocked {
                    self.radiance[arriving.row as usize] += share * arriving.value;
                    self.learned.note(arriving);
                }
            }
            if (number as usize) + 1 < rounds.len() {
                self.learned.accumulate(round.rays);
            }
            watch.end(FrameStage::Direct);
        }
    }

    /// One round's shadow rays.
    fn aim(
        &mut self,
        tracer: &Tracer,
        seen: &VisiblePoints,
        lights: &[Emitter],
        stream: Stream,
        (number, round): (u32, Round),
        first: u64,
    ) {
        self.rays.clear();
        self.arriving.clear();
        let mut before = (u32::MAX, 0);
        for (row, point) in seen.points.iter().enumerate() {
            let pixel = seen.pixel[row];
            before = (pixel, if pixel == before.0 { before.1 + 1 } else { 0 });
            let index = first + u64::from(pixel);
            let (normal, v) = (seen.normals[row], seen.viewers[row]);
            let mixture = self.learned.mixture(row, number > 0);
            for ray in 0..round.rays {
                let [u, place_x, place_y, _] = stream.units(index, number << 16 | ray, before.1);
                let chosen = (ray as f32 + u) / round.rays as f32;
                let (light, probability) = self.learned.choose(row, mixture, chosen);
                let Some(emitter) = lights.get(light as usize) else {
                    continue;
                };
                let place = emitter.place([place_x, place_y]);
                let to = place - point.position;
                if point.normal.dot(to) * point.normal.dot(v) <= 0.0 {
                    continue;
                }
                let arriving = emitter.arriving(place, point.position);
                let value = seen.materials[row].eval(normal, v, to.normalize_or_zero());
                let value = arriving * value / probability;
                if value == Vec3::ZERO {
                    continue;
                }
                self.arriving.push(ShadowRay {
                    row: row as u32,
                    light,
                    value,
                });
                let origin = tracer.lift(point.triangle, point.position, v);
                let end = emitter.before(place, point.position);
                self.rays.push(origin, end - origin, 1.0);
            }
        }
    }
}

/// A round of shadow rays and its weight in the mean.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Round {
    rays: u32,
    weight: f32,
}

/// One round of all the rays, or rounds of [`ROUND`], later ones weighing more: they know more.
fn rounds(plan: ShadowRays) -> Vec<Round> {
    if !plan.adaptive {
        return vec![Round {
            rays: plan.count,
            weight: 1.0,
        }];
    }
    let count = plan.count.div_ceil(ROUND);
    let rays = |k: u32| (plan.count - k * ROUND).min(ROUND);
    (0..count)
        .map(|k| Round {
            rays: rays(k),
            weight: rays(k) as f32 * (k as f32 + 0.25),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounds_have_all_the_rays() {
        for count in 1..40 {
            for adaptive in [false, true] {
                let plan = ShadowRays {
                    count,
                    adaptive,
                    seed: 1,
                };
                let rounds = rounds(plan);
                assert_eq!(rounds.iter().map(|r| r.rays).sum::<u32>(), count);
                assert!(rounds.iter().all(|r| r.rays > 0 && r.weight > 0.0));
            }
        }
    }
}
