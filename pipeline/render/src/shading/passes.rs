//! Gathered answers at points, pass after pass, until their noise is below a bound.

use super::Renderer;
use super::points::PointAnswers;
use crate::error::RenderError;
use crate::options::{Part, RenderOptions};
use crate::view::Lights;
use glam::{DVec3, Vec3};
use rrf_metrics::channel_mean;
use rrf_metrics::relative::epsilon_of;
use rrf_trace::SurfacePoint;

/// Names of a pass's random numbers begin this much after those of the pass before.
const PASS_NAMES: u64 = 1 << 44;

/// How many passes points are answered in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passes {
    /// Passes of every point; from 2 on they tell its noise.
    pub least: u32,
    /// Passes of a point at the most.
    pub most: u32,
    /// Relative standard error that is low enough.
    pub noise: f64,
}

impl Passes {
    /// A single pass.
    pub const ONE: Passes = Passes {
        least: 1,
        most: 1,
        noise: 0.0,
    };
}

/// Sums over the passes of a point.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    radiance: DVec3,
    level: f64,
    square: f64,
    trust: f64,
}

impl Sums {
    fn add(&mut self, radiance: Vec3, trust: f32) {
        let radiance = radiance.as_dvec3();
        let level = channel_mean(radiance.to_array());
        self.radiance += radiance;
        self.level += level;
        self.square += level * level;
        self.trust += f64::from(trust);
    }

    /// Variance of the mean of the channels' mean over `count` passes.
    fn variance(&self, count: u32) -> f64 {
        let n = f64::from(count);
        let squares = (self.square - self.level * self.level / n).max(0.0);
        squares / (n * (n - 1.0))
    }
}

impl Renderer<'_> {
    /// Answers at `points` of the tracer's scene toward unit directions `viewers` under `lights`: the
    /// model, what narrow lobes show, and what is gathered. Random numbers belong to the points' `names`. The
    /// same bits on any number of threads.
    ///
    /// # Errors
    /// Of lights that cannot be rendered.
    pub fn at_points(
        &self,
        points: &[SurfacePoint],
        viewers: &[Vec3],
        names: &[u64],
        lights: &Lights,
        options: &RenderOptions,
    ) -> Result<PointAnswers, RenderError> {
        self.at_points_in_passes((points, viewers), names, lights, options, &Passes::ONE)
    }

    /// [`Renderer::at_points`] in passes of `options.gather` rays: every point gets `passes.least`; those whose
    /// standard error is above the bound get twice as many, and so on. Errors are relative to the point's own light or
    /// to ε of all points', as the relative error is. Since the number of passes follows from what they found, light
    /// that is seldom found is a little too low.
    ///
    /// # Errors
    /// Of lights that cannot be rendered.
    pub fn at_points_in_passes(
        &self,
        (points, viewers): (&[SurfacePoint], &[Vec3]),
        names: &[u64],
        lights: &Lights,
        options: &RenderOptions,
        passes: &Passes,
    ) -> Result<PointAnswers, RenderError> {
        lights.check()?;
        let options = RenderOptions {
            part: Part::Indirect,
            ..*options
        };
        let (job, _) = self.job(lights, &options)?;
        let mut answers = PointAnswers::default();
        let mut sums = vec![Sums::default(); points.len()];
        let mut counts = vec![0u32; points.len()];
        let mut asked: Vec<usize> = (0..points.len()).collect();
        let (mut done, mut wanted) = (0, passes.least.max(1));
        while !asked.is_empty() {
            let own: Vec<SurfacePoint> = asked.iter().map(|&row| points[row]).collect();
            let from: Vec<Vec3> = asked.iter().map(|&row| viewers[row]).collect();
            for pass in done..wanted {
                let shift = u64::from(pass) * PASS_NAMES;
                let named: Vec<u64> = asked.iter().map(|&row| names[row] + shift).collect();
                let found = self.pass(&job, (&own, &from), &named)?;
                for (k, &row) in asked.iter().enumerate() {
                    sums[row].add(found.radiance[k], found.trust[k]);
                    counts[row] += 1;
                }
                if pass == 0 {
                    answers = found;
                }
            }
            done = wanted;
            wanted = wanted.saturating_mul(2).min(passes.most);
            if done >= wanted {
                break;
            }
            let means = sums.iter().zip(&counts);
            let least = epsilon_of(means.map(|(sum, &n)| (sum.radiance / f64::from(n)).to_array()));
            asked.retain(|&row| {
                let level = (sums[row].level / f64::from(counts[row])).max(least);
                sums[row].variance(counts[row]) > (passes.noise * level).powi(2)
            });
        }
        for (row, (sum, &count)) in sums.iter().zip(&counts).enumerate() {
            let n = f64::from(count);
            answers.radiance[row] = (sum.radiance / n).as_vec3();
            answers.trust[row] = (sum.trust / n) as f32;
        }
        Ok(answers)
    }
}
