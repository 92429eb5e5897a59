//! Our side of `tests/peers/training.py`: a net fitted to a problem that others fit too.
//!
//! ```text
//! cargo run --release -p rrf-train --example race -- PROBLEM STEPS [accelerate]
//! ```
//!
//! PROBLEM: little-endian, four i64 (rows trained on, rows kept back, inputs, weights), then f64:
//! x `[rows, inputs]`, targets `[rows, 3]`, weights of the residuals `[rows, 3]`, first weights.
//! Prints a line a step: CPU seconds so far, Σ (s (net − y))² over the rows trained on, the same
//! over the rows kept back. The time for the last is not counted.

use rrf_field::net::Shape;
use rrf_train::LmConfig;
use rrf_train::lm::{Levenberg, Problem};
use rrf_train::problem::{Loss, NetProblem};
use rrf_train::simd::TILE;
use rrf_train::tile::{Batch, Rows};
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
        batch.rows = TILE.min(self.len() - first);
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
        return Err("usage: race PROBLEM STEPS [accelerate]".into());
    };
    let mut config = LmConfig::default();
    if modes.iter().any(|mode| mode == "accelerate") {
        config.acceleration = 0.75;
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
    race(
        part(0, train),
        part(train, rows),
        w.to_vec(),
        steps.parse()?,
        config,
    );
    Ok(())
}

fn race(train: Part, kept: Part, mut w: Vec<f64>, steps: usize, config: LmConfig) {
    let shape = Shape {
        sizes: vec![train.inputs, 20, 10, 3],
    };
    let (mut fit, mut judge) = (problem(&shape, train), problem(&shape, kept));
    println!("0 {} {}", fit.cost(&w), judge.cost(&w));
    let mut lm = Levenberg::new(w.len(), config);
    let mut seconds = 0.0;
    for _ in 0..steps {
        let before = cpu_seconds();
        let step = lm.step(&mut fit, &mut w, 0.0);
        seconds += cpu_seconds() - before;
        match step {
            Ok(step) => println!("{seconds} {} {}", step.data, judge.cost(&w)),
            Err(stop) => {
                eprintln!("stopped: {}", stop.name());
                return;
            }
        }
    }
}

fn problem<'a>(shape: &Shape, part: Part<'a>) -> NetProblem<Part<'a>> {
    NetProblem::new(shape, part, 3 * Rows::len(&part), Loss::Absolute)
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
