//! Area lights for nets that know isotropic point lights only.
//!
//! A one-sided Lambert emitter is no sum of isotropic points on it: those would light the
//! ceiling behind it, and the room ahead no more than the room aside. But indirect light is
//! linear in the lights, so some sum of the nets' own answers Φ(·, l_k) for points l_k within
//! the baked light box comes nearest to what the lamp does. The lamp's indirect light is path
//! traced at a few hundred probes of the surface, per unit of its radiance: y. Points and
//! intensities c_k, of either sign, are chosen such that
//!
//! ```text
//! Σ_probes w² (y − Σ_k c_k Φ_k)² + ε² Σ_k c_k² Σ_probes w² Φ_k²
//! ```
//!
//! is least, w the weight of the relative error. The second term is what the nets' own error ε
//! adds, light by light: without it large intensities of opposite sign would win. Points are
//! added greedily while they help.
//!
//! The c_k [W/sr per W/(sr m²)] belong to the lamp's shape and place alone: its colour and
//! radiance multiply them, without another fit. How far the sum stays from the lamp's light is
//! told ([`StandIn::error`]), Monte Carlo noise taken out.

use crate::compare::EPSILON_SHARE;
use crate::emitter::{self, Emitter};
use crate::error::RenderError;
use crate::frame::luminance;
use crate::tile::raw;
use glam::Vec3;
use rrf_field::columns::{self, Columns};
use rrf_field::{Field, Light};
use rrf_scene::{INVALID, Scene};
use rrf_trace::{Frame, Reflections, Sampling, Stream, SurfacePoint, Tracer, lamp_light};

/// Probes of the surface.
const PROBES: usize = 768;
/// Paths of a probe, in two independent halves.
const PATHS: u32 = 128;
/// Candidate points in the light box.
const CANDIDATES: usize = 128;
/// Most points of one lamp.
const MOST_POINTS: usize = 12;
/// Relative error of a net that large intensities are weighed against.
const NET_ERROR: f64 = 0.05;
/// A point has to lessen the objective by this share of the lamp's own norm.
const WORTHWHILE: f64 = 2e-4;
/// In the fit, places darker than this share of the mean luminance count as if they were as
/// bright: what happens there is hardly seen.
const FIT_SHARE: f64 = 0.3;
/// Stage number of the random stream.
const STAGE_STAND_IN: u32 = 8;

/// Isotropic points that stand for one lamp.
#[derive(Clone, Debug, PartialEq)]
pub struct StandIn {
    /// Positions, and intensities for the lamp as it shines in the scene; some are negative.
    pub points: Vec<Light>,
    /// Relative error of the points' light by the nets over the probes, against the lamp's
    /// traced indirect light with its noise taken out (0 where below the noise, 1 where the
    /// lamp sends no indirect light or nothing stands for it).
    pub error: f64,
}

/// The lamps of a scene, ready for frames.
#[derive(Clone, Debug, Default)]
pub struct Lamps {
    /// Pieces for direct light.
    pub(crate) cells: Vec<Emitter>,
    /// Points for indirect light, lamp by lamp.
    pub stand_ins: Vec<StandIn>,
}

impl Lamps {
    /// The area lights of `scene` and points for them where the nets of `field` know lights:
    /// within `light_box`, where `valid`.
    ///
    /// # Errors
    /// Of tracing, or of the nets' evaluation.
    pub fn new(
        scene: &Scene,
        field: &Field,
        light_box: [Vec3; 2],
        valid: impl Fn(Vec3) -> bool,
    ) -> Result<Lamps, RenderError> {
        let [low, high] = light_box;
        let candidates: Vec<Vec3> = (0..CANDIDATES)
            .map(|k| low + halton3(k) * (high - low))
            .filter(|&place| valid(place))
            .collect();
        let mut stand_ins = Vec::new();
        for light in 0..scene.area_lights.len() as u32 {
            stand_ins.push(stand_in(scene, light, field, light_box, &candidates)?);
        }
        let lamps = emitter::of_area_lights(scene);
        Ok(Lamps {
            stand_ins,
            cells: emitter::cut_all(lamps.into_iter().flatten()),
        })
    }

    /// The points of all lamps.
    pub fn points(&self) -> impl Iterator<Item = Light> + '_ {
        self.stand_ins.iter().flat_map(|s| s.points.iter().copied())
    }
}

/// The points that stand for one area light.
fn stand_in(
    scene: &Scene,
    light: u32,
    field: &Field,
    light_box: [Vec3; 2],
    candidates: &[Vec3],
) -> Result<StandIn, RenderError> {
    let alone = alone(scene, light);
    let tracer = Tracer::new(&alone)?;
    let probes = Probes::new(&tracer, light_box);
    let halves = probes.trace(&tracer, light)?;
    let pairs = halves[0].iter().zip(&halves[1]);
    let mean: Vec<f64> = pairs.map(|(a, b)| 0.5 * (a + b)).collect();
    let fit_weights = weights(&mean, FIT_SHARE);
    let weighted = |values: &[f64]| -> Vec<f64> {
        let pairs = values.iter().zip(&fit_weights);
        pairs.map(|(x, w)| x * w).collect()
    };
    let target = weighted(&mean);
    let mut answers = Vec::with_capacity(candidates.len());
    for &candidate in candidates {
        answers.push(probes.nets(field, candidate)?);
    }
    let columns: Vec<Vec<f64>> = answers.iter().map(|answer| weighted(answer)).collect();
    let chosen = fit(&target, &columns);
    let model = |row: usize| {
        chosen
            .iter()
            .map(|&(k, c)| c * answers[k][row])
            .sum::<f64>()
    };
    let error = error(&halves, &weights(&mean, EPSILON_SHARE), model);
    let radiance = scene.area_lights[light as usize].radiance;
    let points = chosen.into_iter().map(|(k, c)| Light {
        position: candidates[k].to_array(),
        intensity: (radiance * c as f32).to_array(),
    });
    Ok(StandIn {
        points: points.collect(),
        error,
    })
}

/// The scene with one of its area lights shining, white, the others dark.
fn alone(scene: &Scene, light: u32) -> Scene {
    let mut scene = scene.clone();
    for (k, area_light) in (0..).zip(&mut scene.area_lights) {
        area_light.radiance = if k == light { Vec3::ONE } else { Vec3::ZERO };
    }
    scene
}

/// What a relative error multiplies with, row by row: one over the probe's luminance or, where
/// that is less, `share` of the mean; 0 where no light was found.
fn weights(mean: &[f64], share: f64) -> Vec<f64> {
    let level = |rgb: &[f64]| match rgb {
        &[r, g, b] => f64::from(luminance(Vec3::new(r as f32, g as f32, b as f32))),
        _ => 0.0,
    };
    let levels: Vec<f64> = mean.chunks(3).map(level).collect();
    let lit: Vec<f64> = levels.iter().copied().filter(|&y| y > 0.0).collect();
    let least = share * lit.iter().sum::<f64>() / lit.len().max(1) as f64;
    let weight = |y: f64| if y > 0.0 { 1.0 / y.max(least) } else { 0.0 };
    levels.into_iter().flat_map(|y| [weight(y); 3]).collect()
}

/// Relative error of a model of the traced halves: E[(p - a)(p - b)] is free of their noise.
fn error(halves: &[Vec<f64>; 2], weights: &[f64], model: impl Fn(usize) -> f64) -> f64 {
    let lit = weights.iter().filter(|&&w| w > 0.0).count();
    if lit == 0 {
        return 1.0;
    }
    let square = |(row, w): (usize, &f64)| {
        let p = model(row);
        w * w * (p - halves[0][row]) * (p - halves[1][row])
    };
    let sum: f64 = weights.iter().enumerate().map(square).sum();
    (sum.max(0.0) / lit as f64).sqrt()
}

/// Points of the surface, uniform by area, seen from directions by their cosine.
struct Probes {
    points: Vec<SurfacePoint>,
    viewers: Vec<Vec3>,
    rows: Columns,
}

impl Probes {
    /// On the sides that face the middle of the light box; lamps themselves are left out.
    fn new(tracer: &Tracer, [low, high]: [Vec3; 2]) -> Probes {
        let mut probes = Probes {
            points: Vec::new(),
            viewers: Vec::new(),
            rows: Columns::default(),
        };
        let middle = 0.5 * (low + high);
        for k in 0..PROBES {
            let point = tracer.sample_area(halton3(k).to_array());
            let emits = tracer.scene().triangle_light.get(point.triangle as usize);
            if emits.is_none_or(|&light| light != INVALID) {
                continue;
            }
            let side = point.normal.dot(middle - point.position);
            let normal = if side < 0.0 {
                -point.normal
            } else {
                point.normal
            };
            let [u, v] = [7, 11].map(|base| radical_inverse(k + 1, base));
            let local = rrf_trace::bsdf::cosine_hemisphere([u, v]);
            let viewer = Frame::new(normal).to_world(local);
            probes.rows.push(raw(tracer, &point, viewer));
            probes.points.push(point);
            probes.viewers.push(viewer);
        }
        probes
    }

    /// The lamp's indirect light at the probes, two independent halves, channel by channel
    /// within each probe.
    fn trace(&self, tracer: &Tracer, light: u32) -> Result<[Vec<f64>; 2], RenderError> {
        let sampling = Sampling {
            paths: PATHS,
            replicates: 2,
        };
        let estimates = lamp_light(
            tracer,
            &self.points,
            &self.viewers,
            Reflections::More,
            sampling,
            Stream::new(1, STAGE_STAND_IN, light),
            0,
        )?;
        Ok([0, 1].map(|half| {
            let values = (0..estimates.len()).map(|probe| estimates.halves(probe)[half]);
            values.flat_map(|v| v.as_dvec3().to_array()).collect()
        }))
    }

    /// The nets' light at the probes under a point light of 1 W/sr at `place`.
    fn nets(&self, field: &Field, place: Vec3) -> Result<Vec<f64>, RenderError> {
        let mut rows = self.rows.clone();
        for (axis, x) in place.to_array().into_iter().enumerate() {
            rows.columns[columns::L + axis].fill(x);
        }
        let (mut radiance, mut cells) = (<[Vec<f32>; 3]>::default(), Vec::new());
        field.evaluate(&rows, &mut radiance, &mut cells)?;
        let [r, g, b] = &radiance;
        let rgb = r.iter().zip(g).zip(b);
        Ok(rgb
            .flat_map(|((&r, &g), &b)| [r, g, b].map(f64::from))
            .collect())
    }
}

/// The chosen columns with their factors.
fn fit(target: &[f64], columns: &[Vec<f64>]) -> Vec<(usize, f64)> {
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let norm = product(target, target);
    let right: Vec<f64> = columns.iter().map(|c| product(c, target)).collect();
    let gram = |i: usize, j: usize| {
        let ridge = if i == j {
            1.0 + NET_ERROR * NET_ERROR
        } else {
            1.0
        };
        ridge * product(&columns[i], &columns[j])
    };
    let table: Vec<Vec<f64>> = (0..columns.len())
        .map(|i| (0..columns.len()).map(|j| gram(i, j)).collect())
        .collect();
    let mut best: (Vec<(usize, f64)>, f64) = (Vec::new(), norm);
    while best.0.len() < MOST_POINTS && norm > 0.0 {
        let mut next = best.clone();
        for candidate in 0..columns.len() {
            let mut set: Vec<usize> = best.0.iter().map(|&(k, _)| k).collect();
            if set.contains(&candidate) {
                continue;
            }
            set.push(candidate);
            let Some(factors) = solve(&table, &right, &set) else {
                continue;
            };
            // at the least-squares solution: norm - factors . right
            let gained: f64 = set.iter().zip(&factors).map(|(&k, c)| c * right[k]).sum();
            if norm - gained < next.1 {
                next = (set.into_iter().zip(factors).collect(), norm - gained);
            }
        }
        if best.1 - next.1 < WORTHWHILE * norm {
            break;
        }
        best = next;
    }
    best.0
}

/// Solves the rows and columns `set` of a symmetric positive definite system by Cholesky;
/// none where rounding has made it indefinite.
fn solve(table: &[Vec<f64>], right: &[f64], set: &[usize]) -> Option<Vec<f64>> {
    let n = set.len();
    let mut lower = vec![vec![0.0; n]; n];
    for i in 0..n {
        for j in 0..=i {
            let dot: f64 = (0..j).map(|k| lower[i][k] * lower[j][k]).sum();
            let value = table[set[i]][set[j]] - dot;
            if i == j {
                if value.is_nan() || value <= 1e-12 * table[set[i]][set[i]] {
                    return None;
                }
                lower[i][i] = value.sqrt();
            } else {
                lower[i][j] = value / lower[j][j];
            }
        }
    }
    let mut x: Vec<f64> = set.iter().map(|&k| right[k]).collect();
    for i in 0..n {
        let dot: f64 = (0..i).map(|k| lower[i][k] * x[k]).sum();
        x[i] = (x[i] - dot) / lower[i][i];
    }
    for i in (0..n).rev() {
        let dot: f64 = (i + 1..n).map(|k| lower[k][i] * x[k]).sum();
        x[i] = (x[i] - dot) / lower[i][i];
    }
    Some(x)
}

/// Point `index` of the Halton sequence in bases 2, 3 and 5.
fn halton3(index: usize) -> Vec3 {
    Vec3::from_array([2, 3, 5].map(|base| radical_inverse(index + 1, base)))
}

/// The digits of `index` in a base, mirrored behind the point.
fn radical_inverse(index: usize, base: usize) -> f32 {
    let (mut left, mut digit, mut sum) = (index, 1.0, 0.0);
    while left > 0 {
        digit /= base as f64;
        sum += digit * (left % base) as f64;
        left /= base;
    }
    sum as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sum_of_two_columns_is_found_again() {
        let wave = |k: usize| -> Vec<f64> {
            (0..200)
                .map(|i| ((i * (k + 1)) as f64 * 0.37).sin() + 1.5)
                .collect()
        };
        let columns: Vec<Vec<f64>> = (0..6).map(wave).collect();
        let sum = |a: &f64, b: &f64| 2.0 * a - 0.5 * b;
        let target: Vec<f64> = columns[1]
            .iter()
            .zip(&columns[4])
            .map(|(a, b)| sum(a, b))
            .collect();
        let chosen = fit(&target, &columns);
        let factor = |k: usize| chosen.iter().find(|c| c.0 == k).map_or(0.0, |c| c.1);
        // to the ridge, which takes a little of each
        assert!(
            (factor(1) - 2.0).abs() < 0.1 && (factor(4) + 0.5).abs() < 0.1,
            "{chosen:?}"
        );
    }

    /// Against the definition: A x = b.
    #[test]
    fn solves_what_it_is_given() {
        let table = vec![
            vec![4.0, 1.0, 0.5],
            vec![1.0, 3.0, -0.2],
            vec![0.5, -0.2, 2.0],
        ];
        let right = [1.0, -2.0, 0.3];
        let x = solve(&table, &right, &[0, 1, 2]).unwrap();
        for (row, b) in table.iter().zip(right) {
            let ax: f64 = row.iter().zip(&x).map(|(a, x)| a * x).sum();
            assert!((ax - b).abs() < 1e-12);
        }
        assert!(solve(&[vec![0.0]], &[1.0], &[0]).is_none());
    }

    #[test]
    fn halton_points_are_radical_inverses() {
        assert_eq!(halton3(0), Vec3::new(0.5, 1.0 / 3.0, 0.2));
        assert_eq!(halton3(5), Vec3::new(0.375, 2.0 / 9.0, 0.24));
    }
}
