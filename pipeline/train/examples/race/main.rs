//! Our side of `tests/peers/training.py`: a net fitted to a problem that others fit too.
//!
//! ```text
//! cargo run --release -p rrf-train --example race -- PROBLEM STEPS [accelerate] [warm] [single] [reuse=N] [inner=N]
//! ```
//!
//! PROBLEM: little-endian, four i64 (rows trained on, rows kept back, inputs, weights), then f64:
//! x `[rows, inputs]`, targets `[rows, 3]`, weights of the residuals `[rows, 3]`, first weights.
//! `warm` takes the first steps on a quarter of the rows, as whole fits do; `single` multiplies JᵀJ from
//! f32 numbers, as bakes do; `reuse=N` takes N steps with one matrix, `inner=N` iterations each. Prints
//! a line a step: CPU seconds so far, Σ (s (net − y))² over the rows trained on, the same over the
//! rows kept back. The time for the last is not counted.

use rrf_field::net::Shape;
use rrf_lm::{LmConfig, Problem, Solver};
use rrf_train::Precision;
use rrf_train::net::problem::{Loss, NetProblem};
use rrf_train::net::simd::TILE_ROWS;
use rrf_train::net::tile::{Batch, Rows};
use std::error::Error;

/// A stretch of the problem's rows.
#[derive(Clone, Copy)]
struct Part<'a> {
    inputs: usize,
    x: &'a [f64],
    y: &'a [f64],
    s: &'a [f64],
}

impl Rows for Part<'_> {
    fn len(&self) -> usize {
        self.y.len() / 3
    }

    fn load(&self, first: usize, batch: &mut Batch) {
        batch.rows = TILE_ROWS.min(self.len() - first);
        for i in 0..batch.rows {
            let row = &self.x[(first + i) * self.inputs..];
            batch
                .x
                .iter_mut()
                .zip(row)
                .for_each(|(lane, x)| lane[i] = *x);
            for c in 0..3 {
                batch.target[c][i] = self.y[(first + i) * 3 + c];
                batch.gain[c][i] = self.s[(first + i) * 3 + c];
            }
        }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [path, steps, modes @ ..] = args.as_slice() else {
        return Err(
            "usage: race PROBLEM STEPS [accelerate] [warm] [single] [reuse=N] [inner=N]".into(),
        );
    };
    let mut config = LmConfig::default();
    if modes.iter().any(|mode| mode == "accelerate") {
        config.acceleration = 0.75;
    }
    for mode in modes {
        match mode.split_once('=') {
            Some(("reuse", number)) => config.reuse = number.parse()?,
            Some(("inner", number)) => config.inner = number.parse()?,
            _ => {}
        }
    }
    let bytes = std::fs::read(path)?;
    let (words, _) = bytes.as_chunks::<8>();
    let [train, kept, inputs, weights, values @ ..] = words else {
        return Err("no problem".into());
    };
    let [train, kept, inputs, weights] =
        [train, kept, inputs, weights].map(|word| i64::from_le_bytes(*word) as usize);
    let values: Vec<f64> = values
        .iter()
        .map(|word| f64::from_le_bytes(*word))
        .collect();
    let rows = train + kept;
    if values.len() != rows * (inputs + 6) + weights {
        return Err("the problem is cut off".into());
    }
    let (x, rest) = values.split_at(rows * inputs);
    let (y, rest) = rest.split_at(rows * 3);
    let (s, w) = rest.split_at(rows * 3);
    let part = |from: usize, to: usize| Part {
        inputs,
        x: &x[from * inputs..to * inputs],
        y: &y[from * 3..to * 3],
        s: &s[from * 3..to * 3],
    };
    let warm = modes.iter().any(|mode| mode == "warm");
    let precision = if modes.iter().any(|mode| mode == "single") {
        Precision::Single
    } else {
        Precision::Double
    };
    let mut fit = Fit::new(part(train, rows), w.to_vec(), config, precision);
    let steps: usize = steps.parse()?;
    let first = if warm { WARM.min(steps) } else { 0 };
    fit.run(part(0, train.div_ceil(4)), first, part(0, train));
    fit.run(part(0, train), steps - first, part(0, train));
    Ok(())
}

/// Steps on a quarter of the rows.
const WARM: usize = 12;

/// A net under way.
struct Fit<'a> {
    shape: Shape,
    kept: Part<'a>,
    w: Vec<f64>,
    lm: Solver,
    precision: Precision,
    /// Rows of the last phase; the damping is in their proportion.
    rows: usize,
    seconds: f64,
}

impl<'a> Fit<'a> {
    fn new(kept: Part<'a>, w: Vec<f64>, config: LmConfig, precision: Precision) -> Fit<'a> {
        let shape = Shape {
            sizes: vec![kept.inputs, 20, 10, 3],
        };
        let lm = Solver::new(w.len(), config);
        Fit {
            shape,
            kept,
            w,
            lm,
            precision,
            rows: 0,
            seconds: 0.0,
        }
    }

    /// Up to `steps` steps on `some` rows, evaluated on `all`.
    fn run(&mut self, some: Part<'a>, steps: usize, all: Part<'a>) {
        if steps == 0 {
            return;
        }
        let mut problem = self.problem(some);
        let mut evaluators = [self.problem(all), self.problem(self.kept)];
        let [trained, kept] = evaluators
            .each_mut()
            .map(|evaluator| evaluator.cost(&self.w));
        if self.rows == 0 {
            println!("0 {trained} {kept}");
        } else {
            self.lm
                .rescale_damping(some.len() as f64 / self.rows as f64);
            self.lm.settle();
        }
        self.rows = some.len();
        for _ in 0..steps {
            let before = cpu_seconds();
            let step = self.lm.step(&mut problem, &mut self.w, 0.0);
            self.seconds += cpu_seconds() - before;
            if let Err(stop) = step {
                eprintln!("stopped: {}", stop.name());
                return;
            }
            let [trained, kept] = evaluators
                .each_mut()
                .map(|evaluator| evaluator.cost(&self.w));
            println!("{} {trained} {kept}", self.seconds);
        }
    }

    fn problem(&self, part: Part<'a>) -> NetProblem<Part<'a>> {
        NetProblem::new(&self.shape, part, 3 * part.len(), Loss::Absolute).precision(self.precision)
    }
}

/// CPU seconds of this process so far.
fn cpu_seconds() -> f64 {
    let mut time = libc::timespec {
        tv_sec: 0,
        tv_nsec: 0,
    };
    // SAFETY: the call fills the struct that it is given.
    unsafe { libc::clock_gettime(libc::CLOCK_PROCESS_CPUTIME_ID, &raw mut time) };
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}
