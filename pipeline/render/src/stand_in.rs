//! Area lights for nets that know isotropic point lights only.
//!
//! A one-sided Lambert emitter is no sum of isotropic points on it: those would light the
//! ceiling behind it, and the room ahead no more than the room aside. But indirect light is a
//! linear function of where the lamps' own light first falls, so what has to be matched is only
//! that: the irradiance E of the scene's surfaces. A few points within the baked light box, of
//! positive and negative intensity c_k, are chosen such that
//!
//!     ‖a ∘ (E − Σ_k c_k E_k)‖² + ε² Σ_k c_k² ‖a ∘ E_k‖²
//!
//! is least over probes of the surface (a: reflectance, E_k: irradiance by a point of 1 W/sr).
//! The second term is what the nets' own relative error ε adds, light by light: without it
//! large intensities of opposite sign would win. Points are added greedily while they help.
//!
//! The c_k have the unit W/sr per W/(sr m²) and belong to the lamp's shape alone: colour and
//! radiance multiply them, without any new fit. What remains unmatched is told
//! ([`StandIn::misplaced`]).

use crate::emitter::{self, Emitter};
use crate::frame::luminance;
use glam::Vec3;
use rrf_field::Light;
use rrf_scene::Scene;
use rrf_trace::{Rays, Tracer};

/// Probes of the surface, each with two sides.
const PROBES: usize = 2048;
/// Candidate points in the light box.
const CANDIDATES: usize = 96;
/// Points on a lamp that stand for all of it in its irradiance.
const PLACES: usize = 64;
/// Most points of one lamp.
const MOST_POINTS: usize = 12;
/// Relative error of a net that large intensities are weighed against.
const NET_ERROR: f64 = 0.05;
/// A point has to lessen the objective by this share of the lamp's own norm.
const WORTHWHILE: f64 = 2e-4;

/// Isotropic points that stand for one lamp.
#[derive(Clone, Debug, PartialEq)]
pub struct StandIn {
    /// Positions, and intensities for the lamp as it shines in the scene; some are negative.
    pub points: Vec<Light>,
    /// Root of the objective over the lamp's own norm: the share of its first bounce that is
    /// misplaced, the nets' error included. 1 where there are no points.
    pub misplaced: f64,
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
    /// The area lights of `scene`. `unlit` traces the same scene without them, as baked;
    /// `light_box` is where its nets know lights, `valid` whether one may stand at a place.
    pub fn new(
        scene: &Scene,
        unlit: &Tracer,
        light_box: [Vec3; 2],
        valid: impl Fn(Vec3) -> bool,
    ) -> Lamps {
        let lamps = emitter::of_area_lights(scene);
        let probes = Probes::new(unlit);
        let [low, high] = light_box;
        let candidates: Vec<Vec3> = (0..CANDIDATES)
            .map(|k| low + halton3(k) * (high - low))
            .filter(|&place| valid(place))
            .collect();
        let columns: Vec<Vec<f64>> = candidates
            .iter()
            .map(|&position| {
                probes.irradiance(unlit, &[(Emitter::from(&one_watt(position)), position)])
            })
            .collect();
        let stand_in = |(lamp, light): (&Vec<Emitter>, &rrf_scene::AreaLight)| {
            let target = probes.irradiance(unlit, &places(lamp));
            let level = f64::from(luminance(light.radiance));
            let (chosen, misplaced) = fit(&target, &columns, level);
            let points = chosen.into_iter().map(|(k, c)| Light {
                position: candidates[k].to_array(),
                intensity: (light.radiance * c as f32).to_array(),
            });
            StandIn {
                points: points.collect(),
                misplaced,
            }
        };
        Lamps {
            stand_ins: lamps.iter().zip(&scene.area_lights).map(stand_in).collect(),
            cells: emitter::cut_all(lamps.into_iter().flatten()),
        }
    }

    /// The points of all lamps.
    pub fn points(&self) -> impl Iterator<Item = Light> + '_ {
        self.stand_ins.iter().flat_map(|s| s.points.iter().copied())
    }
}

fn one_watt(position: Vec3) -> rrf_scene::PointLight {
    rrf_scene::PointLight {
        position,
        intensity: Vec3::ONE,
    }
}

/// Places on a lamp by power, each with a piece that has its share of the whole's.
fn places(lamp: &[Emitter]) -> Vec<(Emitter, Vec3)> {
    let powers = lamp.iter().map(|e| f64::from(luminance(e.intensity)));
    let mut cumulative = Vec::with_capacity(lamp.len());
    let mut total = 0.0;
    for power in powers {
        total += power;
        cumulative.push(total);
    }
    let place = |k: usize| {
        let target = total * (k as f64 + 0.5) / PLACES as f64;
        let at = cumulative.partition_point(|&c| c <= target);
        let emitter = lamp.get(at.min(lamp.len().checked_sub(1)?))?;
        let share = total / (PLACES as f64 * f64::from(luminance(emitter.intensity)));
        let piece = emitter.dimmed(share as f32);
        let u = halton3(k);
        Some((piece, emitter.place([u.x, u.y])))
    };
    (0..PLACES).filter_map(place).collect()
}

/// Points of the surface, uniform by area: position, unit normal, triangle, reflectance.
struct Probes {
    points: Vec<(rrf_trace::SurfacePoint, f32)>,
}

impl Probes {
    fn new(tracer: &Tracer) -> Probes {
        let point = |k: usize| {
            let point = tracer.sample_area(halton3(k).to_array());
            let material = tracer.material_at(&point);
            (point, luminance(material.base_color))
        };
        Probes {
            points: (0..PROBES).map(point).collect(),
        }
    }

    /// Luminance of the irradiance times reflectance, front sides then back sides.
    fn irradiance(&self, tracer: &Tracer, lights: &[(Emitter, Vec3)]) -> Vec<f64> {
        let mut sum = vec![0.0; 2 * self.points.len()];
        let (mut rays, mut rows, mut blocked) = (Rays::default(), Vec::new(), Vec::new());
        for (emitter, place) in lights {
            rays.clear();
            rows.clear();
            for (row, (point, reflectance)) in self.points.iter().enumerate() {
                let to = *place - point.position;
                let cosine = point.normal.dot(to.normalize_or_zero());
                let arriving = luminance(emitter.arriving(*place, point.position));
                let value = f64::from(arriving * cosine.abs() * reflectance);
                if value == 0.0 {
                    continue;
                }
                let origin = tracer.lift(point.triangle, point.position, to);
                rays.push(origin, emitter.before(*place, origin) - origin, 1.0);
                let side = if cosine > 0.0 { 0 } else { self.points.len() };
                rows.push((row + side, value));
            }
            tracer.occluded(&rays, &mut blocked);
            for (&(row, value), &blocked) in rows.iter().zip(&blocked) {
                sum[row] += if blocked { 0.0 } else { value };
            }
        }
        sum
    }
}

/// The chosen columns with their factors, for a target that has the luminance `level` in it;
/// and the root of the objective over the target's norm.
fn fit(target: &[f64], columns: &[Vec<f64>], level: f64) -> (Vec<(usize, f64)>, f64) {
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
    let (mut chosen, objective) = best;
    for (_, factor) in &mut chosen {
        *factor /= level.max(f64::MIN_POSITIVE);
    }
    let misplaced = if norm > 0.0 {
        objective.max(0.0) / norm
    } else {
        1.0
    };
    (chosen, misplaced.sqrt())
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
    Vec3::from_array([2, 3, 5].map(|base| {
        let (mut left, mut digit, mut sum) = (index + 1, 1.0, 0.0);
        while left > 0 {
            digit /= base as f64;
            sum += digit * (left % base) as f64;
            left /= base;
        }
        sum as f32
    }))
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
        let (chosen, misplaced) = fit(&target, &columns, 1.0);
        let factor = |k: usize| chosen.iter().find(|c| c.0 == k).map_or(0.0, |c| c.1);
        // to the ridge, which takes a little of each
        assert!(
            (factor(1) - 2.0).abs() < 0.1 && (factor(4) + 0.5).abs() < 0.1,
            "{chosen:?}"
        );
        assert!(misplaced < 0.1, "{misplaced}");
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
