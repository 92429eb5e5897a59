//! A net with one hidden layer and many linear outputs, fitted by variable projection.
//!
//! For given hidden weights the outputs are a linear least-squares problem with one matrix for all
//! of them. Levenberg-Marquardt runs over the hidden weights alone, with Kaufman's Jacobian (Golub
//! and Pereyra 1973; Kaufman 1975): column a of the hidden Jacobian for output k is
//! P (s'_h x_j) w_hk with P the projector off the features. So
//!
//! ```text
//! (J'J)_ab = (W W')_h(a)h(b) A_a' P A_b        A_a = s'_h(a) x_j(a), one row a sample
//! (J'r)_a  = A_a' (R W')_h(a)
//! ```
//!
//! and its cost does not grow with the number of outputs.

use ndarray::{Array1, Array2, Axis, s};
use ndarray_linalg::{FactorizeC, SolveC, UPLO};
use rrf_sampling::Stream;

/// Inputs are scaled to zero mean and unit deviation.
pub struct Net {
    mean: Array1<f64>,
    scale: Array1<f64>,
    /// Least and largest of each scaled input: beyond them a net only guesses.
    range: [Array1<f64>; 2],
    /// Shape [hidden, inputs + 1].
    hidden: Array2<f64>,
    /// Shape [1 + inputs + hidden, outputs].
    output: Array2<f64>,
}

/// What a net is fitted to.
pub struct Samples {
    /// Shape [rows, inputs].
    pub inputs: Array2<f64>,
    /// Two independent halves, shape [rows, outputs].
    pub halves: [Array2<f64>; 2],
    /// One a row: errors are relative.
    pub weights: Array1<f64>,
    /// Scale of an output.
    pub scales: Array1<f64>,
    /// TransferRows from here on only judge.
    pub training: usize,
}

#[derive(Clone, Copy)]
pub struct Settings {
    pub hidden: usize,
    /// Ridge on output weights and on hidden weights, relative to a row.
    pub ridge: f64,
    pub decay: f64,
    pub iterations: usize,
}

impl Net {
    /// Fits from a start of its own; returns the net with the least error on the judging rows.
    pub fn fit(samples: &Samples, settings: &Settings, stream: Stream) -> Net {
        let n = samples.training;
        let all = &samples.inputs;
        let training = all.slice(s![..n, ..]);
        let mean = training.mean_axis(Axis(0)).expect("rows");
        let scale = training
            .std_axis(Axis(0), 0.0)
            .mapv(|s| if s > 1e-6 { 1.0 / s } else { 0.0 });
        let inputs = (all - &mean) * &scale;
        let d = inputs.ncols();
        let hidden = start(&inputs, n, settings.hidden, stream);
        let y = (&samples.halves[0] + &samples.halves[1]) * 0.5 * &samples.scales;
        let weights = samples.weights.slice(s![..n]).to_owned();
        let y = y.slice(s![..n, ..]).to_owned() * weights.view().insert_axis(Axis(1));
        let mut fit = Fit {
            x: inputs.slice(s![..n, ..]).to_owned(),
            weights,
            y,
            settings: *settings,
        };
        let extreme = |pick: fn(f64, f64) -> f64, from: f64| {
            inputs.fold_axis(Axis(0), from, |&a, &b| pick(a, b))
        };
        let mut net = Net {
            range: [
                extreme(f64::min, f64::INFINITY),
                extreme(f64::max, f64::NEG_INFINITY),
            ],
            mean,
            scale,
            output: Array2::zeros((1 + d + hidden.nrows(), fit.y.ncols())),
            hidden,
        };
        fit.run(&mut net, |net| net.judge(samples));
        net.output /= &samples.scales;
        net
    }

    /// Noise-free squared error on the judging rows; outputs are scaled.
    fn judge(&self, samples: &Samples) -> f64 {
        let from = samples.training;
        if from == samples.inputs.nrows() {
            return 0.0;
        }
        let inputs = (&samples.inputs.slice(s![from.., ..]) - &self.mean) * &self.scale;
        let p = features(&inputs, &self.hidden).dot(&self.output);
        let mut sum = 0.0;
        for (i, row) in p.rows().into_iter().enumerate() {
            let w = samples.weights[from + i].powi(2);
            for (k, p) in row.iter().enumerate() {
                let off = |h: usize| p - samples.halves[h][[from + i, k]] * samples.scales[k];
                sum += w * off(0) * off(1);
            }
        }
        sum
    }

    /// The outputs for one row of inputs.
    pub fn evaluate(&self, inputs: &[f64]) -> Vec<f64> {
        let mut x = (&Array1::from(inputs.to_vec()) - &self.mean) * &self.scale;
        for (j, x) in x.iter_mut().enumerate() {
            *x = x.clamp(self.range[0][j], self.range[1][j]);
        }
        let x = x.insert_axis(Axis(0));
        features(&x, &self.hidden)
            .dot(&self.output)
            .into_raw_vec_and_offset()
            .0
    }

    /// How many numbers it consists of.
    pub fn weights(&self) -> usize {
        self.hidden.len() + self.output.len()
    }
}

/// 1, the inputs, tanh of the hidden units.
fn features(x: &Array2<f64>, hidden: &Array2<f64>) -> Array2<f64> {
    let (n, d) = x.dim();
    let h = hidden.nrows();
    let mut f = Array2::ones((n, 1 + d + h));
    f.slice_mut(s![.., 1..1 + d]).assign(x);
    let mut units = x.dot(&hidden.slice(s![.., ..d]).t()) + hidden.slice(s![.., d]);
    units.mapv_inplace(f64::tanh);
    f.slice_mut(s![.., 1 + d..]).assign(&units);
    f
}

/// Units that bend at samples, in random directions.
fn start(x: &Array2<f64>, n: usize, units: usize, stream: Stream) -> Array2<f64> {
    let d = x.ncols();
    let mut hidden = Array2::zeros((units, d + 1));
    for h in 0..units {
        let u = stream.units(h as u64, 0, 0);
        let at = x.row((u[0] * n as f32) as usize);
        let mut offset = 0.0;
        for j in 0..d {
            let v = stream.units(h as u64, 1 + j as u32, 0);
            let normal = (-2.0 * f64::from(1.0 - v[0]).ln()).sqrt()
                * (std::f64::consts::TAU * f64::from(v[1])).cos();
            hidden[[h, j]] = normal * 1.2 / (d as f64).sqrt();
            offset -= hidden[[h, j]] * at[j];
        }
        hidden[[h, d]] = offset;
    }
    hidden
}

struct Fit {
    x: Array2<f64>,
    weights: Array1<f64>,
    /// Weighted targets.
    y: Array2<f64>,
    settings: Settings,
}

impl Fit {
    fn run(&mut self, net: &mut Net, judge: impl Fn(&Net) -> f64) {
        let mut damping = 1e-2;
        let Some((mut cost, output)) = self.project(&net.hidden) else {
            return;
        };
        net.output = output;
        let mut best = (judge(net), net.hidden.clone(), net.output.clone());
        for _ in 0..self.settings.iterations {
            let Some((gram, gradient)) = self.normal_equations(net) else {
                break;
            };
            let mut improved = false;
            for _ in 0..6 {
                let mut damped = gram.clone();
                let trace = gram.diag().mean().unwrap_or(1.0);
                damped
                    .diag_mut()
                    .mapv_inplace(|x| x + damping * x.max(1e-3 * trace) + 1e-12);
                let Ok(step) = damped
                    .factorizec(UPLO::Lower)
                    .and_then(|f| f.solvec(&gradient))
                else {
                    damping *= 10.0;
                    continue;
                };
                let step = step.to_shape(net.hidden.dim()).expect("shape").to_owned();
                let hidden = &net.hidden + &step;
                if let Some((next, output)) = self.project(&hidden)
                    && next < cost
                {
                    improved = (cost - next) > 1e-4 * cost;
                    cost = next;
                    net.hidden = hidden;
                    net.output = output;
                    damping = (damping * 0.3).max(1e-8);
                    break;
                }
                damping *= 4.0;
            }
            let judged = judge(net);
            if judged < best.0 {
                best = (judged, net.hidden.clone(), net.output.clone());
            }
            if !improved {
                break;
            }
        }
        (net.hidden, net.output) = (best.1, best.2);
    }

    fn ridge(&self) -> f64 {
        self.settings.ridge * self.weights.mapv(|w| w * w).sum()
    }

    /// The best output weights for given hidden ones, and what is left.
    fn project(&self, hidden: &Array2<f64>) -> Option<(f64, Array2<f64>)> {
        let f = features(&self.x, hidden) * self.weights.view().insert_axis(Axis(1));
        let mut gram = f.t().dot(&f);
        let ridge = self.ridge();
        gram.diag_mut().mapv_inplace(|x| x + ridge);
        let factor = gram.factorizec(UPLO::Lower).ok()?;
        let right = f.t().dot(&self.y);
        let mut output = Array2::zeros(right.dim());
        for (k, column) in right.columns().into_iter().enumerate() {
            output.column_mut(k).assign(&factor.solvec(&column).ok()?);
        }
        let rest = &self.y - f.dot(&output);
        let square = |m: &Array2<f64>| m.iter().map(|x| x * x).sum::<f64>();
        let decay = self.settings.decay * self.ridge() / self.settings.ridge.max(1e-12);
        let cost = square(&rest) + ridge * square(&output) + decay * square(hidden);
        cost.is_finite().then_some((cost, output))
    }

    fn normal_equations(&self, net: &Net) -> Option<(Array2<f64>, Array1<f64>)> {
        let (n, d) = self.x.dim();
        let h = net.hidden.nrows();
        let f = features(&self.x, &net.hidden);
        let mut a = Array2::zeros((n, h * (d + 1)));
        for i in 0..n {
            for u in 0..h {
                let t = f[[i, 1 + d + u]];
                let slope = (1.0 - t * t) * self.weights[i];
                for j in 0..d {
                    a[[i, u * (d + 1) + j]] = slope * self.x[[i, j]];
                }
                a[[i, u * (d + 1) + d]] = slope;
            }
        }
        let f = f * self.weights.view().insert_axis(Axis(1));
        let mut gram = f.t().dot(&f);
        let ridge = self.ridge();
        gram.diag_mut().mapv_inplace(|x| x + ridge);
        let factor = gram.factorizec(UPLO::Lower).ok()?;
        let cross = f.t().dot(&a);
        let mut solved = Array2::zeros(cross.dim());
        for (k, column) in cross.columns().into_iter().enumerate() {
            solved.column_mut(k).assign(&factor.solvec(&column).ok()?);
        }
        let mut j = a.t().dot(&a) - cross.t().dot(&solved);
        let w = net.output.slice(s![1 + d.., ..]);
        let ww = w.dot(&w.t());
        for ((p, q), x) in j.indexed_iter_mut() {
            *x *= ww[[p / (d + 1), q / (d + 1)]];
        }
        let decay = self.settings.decay * self.ridge() / self.settings.ridge.max(1e-12);
        j.diag_mut().mapv_inplace(|x| x + decay);
        let rest = &self.y - f.dot(&net.output);
        let back = rest.dot(&w.t());
        let mut gradient = Array1::zeros(h * (d + 1));
        for p in 0..h * (d + 1) {
            gradient[p] = a.column(p).dot(&back.column(p / (d + 1)));
            gradient[p] -= decay * net.hidden[[p / (d + 1), p % (d + 1)]];
        }
        Some((j, gradient))
    }
}
