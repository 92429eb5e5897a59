//! One Levenberg-Marquardt iteration against the processor's own bound, and a whole fit.
//!
//! `cargo bench -p rrf-train`. One thread, CPU time (wall time is not one's own on a machine that
//! others use). The iteration is that of a 12-20-10-3 net (503
//! weights) on 8,192 rows in f64: forward pass, JᵀWJ, JᵀWr, Cholesky, step, one trial cost. It
//! is to be read beside `peak`: as many fused multiply-adds as the structured JᵀWJ needs,
//! from registers.

mod cpu_time;

use cpu_time::CpuTime;
use criterion::{Criterion, criterion_group, criterion_main};
use multiversion::multiversion;
use multiversion::target::target_cfg_f;
use rrf_field::columns::Columns;
use rrf_field::net::Shape;
use rrf_lm::{LmConfig, NormalEquations, Problem, Solver};
use rrf_sampling::{Stage, Stream};
use rrf_train::net::blocks::Precision;
use rrf_train::net::problem::{Loss, NetProblem};
use rrf_train::net::simd::{TILE_ROWS, fma};
use rrf_train::net::tile::{Batch, Rows};
use rrf_train::{Decay, TrainConfig, fit_cell};
use std::hint::black_box;

const ROWS: usize = 8192;

/// Rows of random inputs; the targets are smooth functions of them.
struct MadeUp {
    x: Vec<[f64; 12]>,
}

impl MadeUp {
    fn new() -> MadeUp {
        let stream = Stream::new(1, Stage::Test, 0);
        let row = |row: u64| std::array::from_fn(|d| 3.4 * stream.f64(row, d as u32) - 1.7);
        MadeUp {
            x: (0..ROWS as u64).map(row).collect(),
        }
    }
}

impl Rows for MadeUp {
    fn len(&self) -> usize {
        ROWS
    }

    fn load(&self, first: usize, batch: &mut Batch) {
        batch.rows = TILE_ROWS.min(ROWS - first);
        for (i, x) in self.x[first..].iter().take(batch.rows).enumerate() {
            batch.x.iter_mut().zip(x).for_each(|(lane, x)| lane[i] = *x);
            for c in 0..3 {
                batch.target[c][i] = (x[c] * x[c + 3]).tanh() + 0.3 * x[c + 6];
                batch.gain[c][i] = 1.0;
            }
            batch.base[i] = 3.0;
        }
    }
}

fn shape() -> Shape {
    Shape {
        sizes: vec![12, 20, 10, 3],
    }
}

fn first_weights() -> Vec<f64> {
    let stream = Stream::new(2, Stage::Test, 0);
    (0..shape().weights() as u64)
        .map(|i| 0.6 * stream.f64(i, 0) - 0.3)
        .collect()
}

/// Fused multiply-adds of the structured normal equations a row: pairs of gradients times pairs
/// of inputs, over all pairs of layers.
fn fused_multiply_adds(sizes: &[usize]) -> usize {
    let triangle = |n: usize| n * (n + 1) / 2;
    let top = sizes.len() - 2;
    let mut sum = 0;
    for p in 0..=top {
        for q in 0..=p {
            let inputs = if p == q {
                triangle(sizes[p] + 1)
            } else {
                (sizes[p] + 1) * (sizes[q] + 1)
            };
            let gradients = match (p == top, q == top, p == q) {
                (true, true, _) => 3,
                (true, false, _) => 3 * sizes[q + 1],
                (false, _, true) => triangle(sizes[p + 1]),
                (false, _, false) => sizes[p + 1] * sizes[q + 1],
            };
            sum += inputs * gradients;
        }
    }
    sum
}

/// `count` fused multiply-adds on accumulators that stay in registers.
#[multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512vl+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
// In any one copy, two of the conditions are the same constant.
#[allow(clippy::ifs_same_cond)]
fn peak(count: usize, x: f64) -> f64 {
    if target_cfg_f!(target_feature = "avx512f") {
        spin::<192, true>(count, x)
    } else if target_cfg_f!(any(target_feature = "fma", target_arch = "aarch64")) {
        spin::<48, true>(count, x)
    } else {
        spin::<24, false>(count, x)
    }
}

#[inline(always)]
fn spin<const N: usize, const FMA: bool>(count: usize, x: f64) -> f64 {
    let mut sums: [f64; N] = std::array::from_fn(|i| i as f64);
    for _ in 0..count / N {
        for s in &mut sums {
            *s = fma::<FMA>(*s, x, x);
        }
    }
    sums.iter().sum()
}

fn iteration(c: &mut Criterion<CpuTime>) {
    let mut group = c.benchmark_group("12-20-10-3, 8192 rows");
    group.sample_size(30);
    let count = fused_multiply_adds(&shape().sizes) * ROWS;
    group.bench_function("peak", |b| b.iter(|| peak(count, black_box(0.999))));
    let mut problem = NetProblem::new(&shape(), MadeUp::new(), 3 * ROWS, Loss::Absolute);
    let w = first_weights();
    let mut normal = NormalEquations::zeros(w.len());
    group.bench_function("normal equations", |b| {
        b.iter(|| problem.linearise(black_box(&w), &mut normal))
    });
    let single = NetProblem::new(&shape(), MadeUp::new(), 3 * ROWS, Loss::Absolute);
    let mut single = single.precision(Precision::Single);
    group.bench_function("normal equations, f32 products", |b| {
        b.iter(|| single.linearise(black_box(&w), &mut normal))
    });
    group.bench_function("cost", |b| b.iter(|| problem.cost(black_box(&w))));
    let mut out = vec![0.0; w.len()];
    group.bench_function("gradient", |b| {
        b.iter(|| problem.gradient(black_box(&w), &mut out))
    });
    group.bench_function("product with the normal equations' matrix", |b| {
        b.iter(|| problem.product(black_box(&w), &mut out))
    });
    let mut lm = Solver::new(w.len(), LmConfig::default());
    group.bench_function("iteration", |b| {
        b.iter(|| {
            let mut w = w.clone();
            lm.step(&mut problem, &mut w, 1e-3)
        });
    });
    let mut lm = Solver::new(w.len(), LmConfig::default());
    group.bench_function("iteration, f32 products", |b| {
        b.iter(|| {
            let mut w = w.clone();
            lm.step(&mut single, &mut w, 1e-3)
        });
    });
    group.finish();
}

/// A cell of 6,000 rows whose radiance is a smooth function of place and light.
fn whole_fit(c: &mut Criterion<CpuTime>) {
    let stream = Stream::new(3, Stage::Test, 0);
    let mut rows = Columns::default();
    let mut halves = [Vec::new(), Vec::new()];
    for row in 0..6000 {
        let u: Vec<f32> = (0..18).map(|d| stream.f32(row, d)).collect();
        for (column, u) in rows.columns.iter_mut().zip(&u) {
            column.push(*u);
        }
        let near = 0.1 + (u[0] - u[9]).powi(2) + (u[2] - u[11]).powi(2);
        let y = [0.1 / near, 0.05 / near + u[1], 0.2 * u[1] / near];
        halves[0].push(y.map(|y| y * 1.01));
        halves[1].push(y.map(|y| y * 0.99));
    }
    let validation: Vec<bool> = (0..6000).map(|row| row % 10 < 3).collect();
    let config = TrainConfig {
        decay: Decay::Evidence(1e-6),
        ..TrainConfig::default()
    };
    let mut group = c.benchmark_group("whole fit, 6000 rows");
    group.sample_size(10);
    group.bench_function("default", |b| {
        b.iter(|| {
            let [a, b] = [&halves[0], &halves[1]].map(Vec::as_slice);
            fit_cell(0, &rows, [a, b], &validation, &config)
        });
    });
    group.finish();
}

criterion_group!(
    name = benches;
    config = Criterion::default().with_measurement(CpuTime);
    targets = iteration, whole_fit
);
criterion_main!(benches);
