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
//! told ([`LightProxy::error`]), Monte Carlo noise taken out.

mod probes;
mod sparse;

use crate::direct::emitter::{self, Emitter};
use crate::error::RenderError;
use glam::Vec3;
use probes::{Probes, halton3};
use rrf_field::{Field, Light};
use rrf_metrics::color::luminance;
use rrf_metrics::relative::EPSILON_SHARE;
use rrf_scene::Scene;
use rrf_trace::Tracer;
use sparse::fit_sparse;

/// Candidate points in the light box.
const CANDIDATES: usize = 128;
/// In the fit, places darker than this share of the mean luminance count as if they were as
/// bright: what happens there is hardly seen.
const FIT_SHARE: f64 = 0.3;

/// Isotropic points that stand for one lamp.
#[derive(Clone, Debug, PartialEq)]
pub struct LightProxy {
    /// Positions, and intensities for the lamp as it shines in the scene; some are negative.
    pub points: Vec<Light>,
    /// Relative error of the points' light by the nets over the probes, against the lamp's
    /// traced indirect light with its noise taken out (0 where below the noise, 1 where the
    /// lamp sends no indirect light or nothing stands for it).
    pub error: f64,
}

/// The lamps of a scene, ready for frames.
#[derive(Clone, Debug, Default)]
pub struct AreaLights {
    /// Pieces of their surface, for direct light.
    pub(crate) pieces: Vec<Emitter>,
    /// Points for indirect light, lamp by lamp.
    pub proxies: Vec<LightProxy>,
    /// The scene with its lamps dimmed, if they are.
    pub(crate) scene: Option<Box<Scene>>,
}

impl AreaLights {
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
    ) -> Result<AreaLights, RenderError> {
        let [low, high] = light_box;
        let candidates: Vec<Vec3> = (0..CANDIDATES)
            .map(|k| low + halton3(k) * (high - low))
            .filter(|&place| valid(place))
            .collect();
        let mut proxies = Vec::new();
        for light in 0..scene.area_lights.len() as u32 {
            proxies.push(light_proxy(scene, light, field, light_box, &candidates)?);
        }
        let emitters = emitter::of_area_lights(scene);
        Ok(AreaLights {
            proxies,
            pieces: emitter::cut_all(emitters.into_iter().flatten()),
            scene: None,
        })
    }

    /// The area lights of `scene` for direct light alone: a transfer knows lamps as they are.
    pub fn without_proxies(scene: &Scene) -> AreaLights {
        let emitters = emitter::of_area_lights(scene);
        AreaLights {
            proxies: Vec::new(),
            pieces: emitter::cut_all(emitters.into_iter().flatten()),
            scene: None,
        }
    }

    /// The area lights of `scene`, of which these are all, each times its colour of `dims`.
    pub fn dimmed(&self, scene: &Scene, dims: &[Vec3]) -> AreaLights {
        let mut scene = scene.clone();
        for (light, &dim) in scene.area_lights.iter_mut().zip(dims) {
            light.radiance *= dim;
        }
        let mut lights = AreaLights::without_proxies(&scene);
        lights.proxies = self.proxies.clone();
        for (proxy, &dim) in lights.proxies.iter_mut().zip(dims) {
            for point in &mut proxy.points {
                point.intensity = (Vec3::from(point.intensity) * dim).to_array();
            }
        }
        lights.scene = Some(Box::new(scene));
        lights
    }

    /// The points of all lamps.
    pub fn points(&self) -> impl Iterator<Item = Light> + '_ {
        self.proxies.iter().flat_map(|s| s.points.iter().copied())
    }
}

/// The points that stand for one area light.
fn light_proxy(
    scene: &Scene,
    light: u32,
    field: &Field,
    light_box: [Vec3; 2],
    candidates: &[Vec3],
) -> Result<LightProxy, RenderError> {
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
    let chosen = fit_sparse(&target, &columns);
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
    Ok(LightProxy {
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

/// Weights of a relative error, row by row: one over the probe's luminance or, where
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
