//! Nets fitted by variable projection.
//!
//! For given hidden weights the outputs are a linear least-squares problem with one matrix for all
//! of them. Levenberg-Marquardt runs over the hidden weights alone, with Kaufman's Jacobian (Golub
//! and Pereyra 1973; Kaufman 1975): column a of the hidden Jacobian for output k is
//! P (s'_h x_j) w_hk with P the projector off the features. So
//!
//! ```text
//! (J'J)_ab = (W W')_h(a)h(b) A_a' P A_b        A_a = s'_h(a) x_j(a), one row a sample
//! (J'r)_a  = -A_a' (R W')_h(a)                 R: what is left of the targets
//! ```
//!
//! and its cost does not grow with the number of outputs.

use crate::model::{PackedRows, TransferNet};
use crate::tracing::Stream;
use ndarray::{Array1, Array2, Axis, s};
use rrf_lm::{Cholesky, LmConfig, NormalEquations, Problem, Scaling, Solver};

/// Targets of a net's fit.
pub(crate) struct Samples {
    /// Which of a point's inputs.
    pub(crate) inputs: Vec<u8>,
    /// Shape [rows, inputs].
    pub(crate) x: Array2<f64>,
    /// Shape [rows, outputs].
    pub(crate) y: Array2<f64>,
    /// One a row: errors are relative.
    pub(crate) weights: Array1<f64>,
    /// Scale of an output.
    pub(crate) scales: Array1<f64>,
}

/// How nets are fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NetConfig {
    /// Hidden units.
    pub units: usize,
    /// Ridge on output weights, relative to the rows' weight.
    pub ridge: f64,
    /// Decay of hidden weights, relative to the ridge on outputs.
    pub decay: f64,
    /// Most steps.
    pub steps: usize,
}

impl Default for NetConfig {
    fn default() -> NetConfig {
        NetConfig {
            units: 16,
            ridge: 1e-4,
            decay: 1e-1,
            steps: 60,
        }
    }
}

/// Fits a net from a start of its own and returns it beside its outputs, shape [features, outputs];
/// none where there is no row.
pub(crate) fn fit_net(
    samples: &Samples,
    config: &NetConfig,
    stream: Stream,
) -> Option<(TransferNet, Vec<f32>)> {
    let mean = samples.x.mean_axis(Axis(0))?;
    let scale = (samples.x.std_axis(Axis(0), 0.0)).mapv(|s| if s > 1e-6 { 1.0 / s } else { 0.0 });
    let x = (&samples.x - &mean) * &scale;
    let w = samples.weights.view().insert_axis(Axis(1));
    let y = &samples.y * &samples.scales * w;
    let hidden = start(&x, config.units, stream);
    let extreme = |pick: fn(f64, f64) -> f64, from: f64| {
        let most = x.fold_axis(Axis(0), from, |&a, &b| pick(a, b));
        single(most.iter())
    };
    let mut net = TransferNet {
        inputs: samples.inputs.clone(),
        low: extreme(f64::min, f64::INFINITY),
        high: extreme(f64::max, f64::NEG_INFINITY),
        mean: single(mean.iter()),
        scale: single(scale.iter()),
        hidden: Vec::new(),
        output: PackedRows::default(),
    };
    let total = samples.weights.mapv(|w| w * w).sum();
    let mut fit = Projection {
        ridge: config.ridge * total,
        x,
        y,
        weights: samples.weights.clone(),
        units: config.units,
    };
    let mut w = hidden;
    // the decay is over the hidden weights' own number, on the scale of the targets' squares
    let alpha = config.decay * fit.ridge;
    let settings = LmConfig {
        scaling: Scaling::Clamped { floor: 1e-3 },
        tau: 1e-2,
        cost: 1e-4,
        ..LmConfig::default()
    };
    let mut solver = Solver::new(w.len(), settings);
    for _ in 0..config.steps {
        match solver.step(&mut fit, &mut w, alpha) {
            Ok(step) if step.before - step.after > settings.cost * step.before => {}
            _ => break,
        }
    }
    let output = fit.project(&fit.unpack(&w))?.output / &samples.scales;
    net.hidden = single(w.iter());
    Some((net, single(output.iter())))
}

fn single<'a>(values: impl Iterator<Item = &'a f64>) -> Vec<f32> {
    values.map(|&x| x as f32).collect()
}

/// Units that bend at samples, in random directions.
fn start(x: &Array2<f64>, units: usize, stream: Stream) -> Vec<f64> {
    let (n, d) = x.dim();
    let mut hidden = Vec::with_capacity(units * (d + 1));
    for h in 0..units {
        let u = stream.units(h as u64, 0, 0);
        let at = x.row(((u[0] * n as f32) as usize).min(n - 1));
        let mut offset = 0.0;
        for j in 0..d {
            let v = stream.units(h as u64, 1 + j as u32, 0);
            let normal = (-2.0 * f64::from(1.0 - v[0]).ln()).sqrt()
                * (std::f64::consts::TAU * f64::from(v[1])).cos();
            hidden.push(normal * 1.2 / (d as f64).sqrt());
            offset -= hidden[hidden.len() - 1] * at[j];
        }
        hidden.push(offset);
    }
    hidden
}

/// The problem over the hidden weights.
struct Projection {
    x: Array2<f64>,
    weights: Array1<f64>,
    /// Weighted, scaled targets.
    y: Array2<f64>,
    ridge: f64,
    units: usize,
}

/// The best outputs for given hidden weights.
struct Projected {
    features: Array2<f64>,
    factor: Cholesky,
    output: Array2<f64>,
    rest: Array2<f64>,
    cost: f64,
}

impl Projection {
    fn unpack(&self, w: &[f64]) -> Array2<f64> {
        let d = self.x.ncols() + 1;
        Array2::from_shape_fn((self.units, d), |(h, j)| w[h * d + j])
    }

    /// 1, the inputs, tanh of the hidden units; not weighted.
    fn features(&self, hidden: &Array2<f64>) -> Array2<f64> {
        let (n, d) = self.x.dim();
        let mut f = Array2::ones((n, 1 + d + self.units));
        f.slice_mut(s![.., 1..1 + d]).assign(&self.x);
        let mut units = self.x.dot(&hidden.slice(s![.., ..d]).t()) + hidden.slice(s![.., d]);
        units.mapv_inplace(f64::tanh);
        f.slice_mut(s![.., 1 + d..]).assign(&units);
        f
    }

    fn project(&self, hidden: &Array2<f64>) -> Option<Projected> {
        let features = self.features(hidden);
        let f = &features * &self.weights.view().insert_axis(Axis(1));
        let gram = f.t().dot(&f);
        let mut factor = Cholesky::default();
        let added = vec![self.ridge; gram.nrows()];
        factor.factor(gram.as_slice()?, &added).ok()?;
        let right = f.t().dot(&self.y);
        let output = solve(&factor, &right)?;
        let rest = &self.y - f.dot(&output);
        let square = |m: &Array2<f64>| m.iter().map(|x| x * x).sum::<f64>();
        let cost = square(&rest) + self.ridge * square(&output);
        Some(Projected {
            features,
            factor,
            output,
            rest,
            cost,
        })
    }
}

/// The factor's solution for every column.
fn solve(factor: &Cholesky, right: &Array2<f64>) -> Option<Array2<f64>> {
    let mut columns = right.t().as_standard_layout().into_owned();
    for mut column in columns.rows_mut() {
        factor.solve(column.as_slice_mut()?).ok()?;
    }
    Some(columns.t().as_standard_layout().into_owned())
}

impl Problem for Projection {
    fn cost(&mut self, w: &[f64]) -> f64 {
        let projected = self.project(&self.unpack(w));
        projected.map_or(f64::INFINITY, |p| p.cost)
    }

    fn linearise(&mut self, w: &[f64], normal: &mut NormalEquations) -> f64 {
        let Some(at) = self.project(&self.unpack(w)) else {
            return f64::INFINITY;
        };
        let (n, d) = self.x.dim();
        let width = d + 1;
        let mut a = Array2::zeros((n, self.units * width));
        for i in 0..n {
            let inputs = self.x.row(i);
            for u in 0..self.units {
                let t = at.features[[i, 1 + d + u]];
                let slope = (1.0 - t * t) * self.weights[i];
                for j in 0..d {
                    a[[i, u * width + j]] = slope * inputs[j];
                }
                a[[i, u * width + d]] = slope;
            }
        }
        let f = &at.features * &self.weights.view().insert_axis(Axis(1));
        let cross = f.t().dot(&a);
        let Some(solved) = solve(&at.factor, &cross) else {
            return f64::INFINITY;
        };
        let gram = a.t().dot(&a) - cross.t().dot(&solved);
        let outputs = at.output.slice(s![1 + d.., ..]);
        let products = outputs.dot(&outputs.t());
        let back = at.rest.dot(&outputs.t());
        let count = self.units * width;
        for p in 0..count {
            for q in 0..count {
                normal.matrix[p * count + q] = gram[[p, q]] * products[[p / width, q / width]];
            }
            normal.gradient[p] = -a.column(p).dot(&back.column(p / width));
        }
        at.cost
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rrf_sampling::Stage;

    fn wavy() -> Samples {
        let stream = Stream::new(3, Stage::Test, 0);
        let n = 300;
        let x = Array2::from_shape_fn((n, 2), |(i, j)| {
            f64::from(stream.units(i as u64, 0, 0)[j]) * 4.0 - 2.0
        });
        let y = Array2::from_shape_fn((n, 3), |(i, k)| {
            let (a, b) = (x[[i, 0]], x[[i, 1]]);
            (0.8 * a + 0.3 * k as f64).sin() * (-0.3 * b * b).exp() + 0.2 * b
        });
        Samples {
            inputs: vec![0, 1],
            y,
            weights: Array1::from_shape_fn(n, |i| 1.0 + 0.5 * x[[i, 1]]),
            scales: Array1::ones(3),
            x,
        }
    }

    fn projection(samples: &Samples) -> Projection {
        let w = samples.weights.view().insert_axis(Axis(1));
        Projection {
            x: samples.x.clone(),
            y: &samples.y * &w,
            weights: samples.weights.clone(),
            ridge: 1e-3,
            units: 5,
        }
    }

    /// The gradient is that of the cost, whose outputs are solved for anew at each place: Kaufman's
    /// approximation leaves it exact (central differences).
    #[test]
    fn the_gradient_is_that_of_the_projected_cost() {
        let samples = wavy();
        let mut problem = projection(&samples);
        let w = start(&samples.x, 5, Stream::new(8, Stage::Test, 1));
        let mut normal = NormalEquations::zeros(w.len());
        let cost = problem.linearise(&w, &mut normal);
        assert!((problem.cost(&w) / cost - 1.0).abs() < 1e-12);
        for p in 0..w.len() {
            let step = 1e-5;
            let at = |by: f64| {
                let mut moved = w.clone();
                moved[p] += by;
                moved
            };
            let slope = (problem.cost(&at(step)) - problem.cost(&at(-step))) / (2.0 * step);
            let found = 2.0 * normal.gradient[p];
            assert!(
                (slope - found).abs() < 1e-6 * (1.0 + cost),
                "{p}: {slope} {found}"
            );
            assert!(normal.matrix[p * w.len() + p] >= 0.0);
        }
    }

    /// Twelve units follow a smooth function to 1 %; the same bits each time.
    #[test]
    fn follows_a_smooth_function() {
        let samples = wavy();
        let config = NetConfig {
            units: 12,
            ridge: 1e-6,
            ..NetConfig::default()
        };
        let stream = Stream::new(8, Stage::Test, 2);
        let fit = fit_net(&samples, &config, stream).unwrap();
        assert_eq!(Some(&fit), fit_net(&samples, &config, stream).as_ref());
        let (mut net, output) = fit;
        net.output = PackedRows::pack(&output, 3);
        let unit = net.contract(&[glam::Vec3::ONE]);
        let (mut off, mut all) = (0.0, 0.0);
        for i in 0..samples.x.nrows() {
            let mut inputs = [0.0f32; crate::query::INPUTS];
            inputs[0] = samples.x[[i, 0]] as f32;
            inputs[1] = samples.x[[i, 1]] as f32;
            let found = f64::from(net.evaluate(&inputs, &unit).x);
            off += (found - samples.y[[i, 0]]).powi(2);
            all += samples.y[[i, 0]].powi(2);
        }
        assert!((off / all).sqrt() < 0.01, "{}", (off / all).sqrt());
    }
}
