//! Weights that start where gradients vanish, and damping at its end.

use rrf_field::net::{self, Shape};
use rrf_lm::{LmConfig, Minimum, NormalEquations, Problem, Scaling, Solver, Termination, minimise};
use rrf_sampling::{Stage, Stream};
use rrf_train::net::problem::{Loss, NetProblem};
use rrf_train::net::simd::TILE_ROWS;
use rrf_train::net::tile::{Batch, Rows};

/// 400 rows of three inputs whose targets a net of the same shape made: an exact teacher.
pub struct Taught {
    shape: Shape,
    teacher: Vec<f64>,
}

const ROWS: usize = 400;

impl Taught {
    pub fn new() -> Taught {
        let shape = Shape {
            sizes: vec![3, 6, 4, 3],
        };
        let teacher = random(&shape, 1, 1.0);
        Taught { shape, teacher }
    }

    pub fn problem(&self) -> NetProblem<&Taught> {
        NetProblem::new(&self.shape, self, 3 * ROWS, Loss::Absolute)
    }
}

fn random(shape: &Shape, seed: u64, size: f64) -> Vec<f64> {
    let stream = Stream::new(seed, Stage::Test, 1);
    (0..shape.weights() as u64)
        .map(|i| size * (2.0 * stream.f64(i, 0) - 1.0))
        .collect()
}

impl Rows for Taught {
    fn len(&self) -> usize {
        ROWS
    }

    fn load(&self, first: usize, batch: &mut Batch) {
        let stream = Stream::new(9, Stage::Test, 2);
        batch.rows = TILE_ROWS.min(ROWS - first);
        for i in 0..batch.rows {
            let at = (first + i) as u64;
            let x: Vec<f64> = (0..3).map(|d| 3.4 * stream.f64(at, d) - 1.7).collect();
            batch
                .x
                .iter_mut()
                .zip(&x)
                .for_each(|(lane, x)| lane[i] = *x);
            let y = net::evaluate(&self.shape, &self.teacher, &x);
            for (c, y) in y.iter().enumerate() {
                batch.target[c][i] = *y;
                batch.gain[c][i] = 1.0;
            }
        }
    }
}

/// Steps from `w`; every weight stays finite, the cost never rises.
fn descend(w: &mut [f64], config: LmConfig, alpha: f64) -> Minimum {
    let taught = Taught::new();
    let mut problem = taught.problem();
    let start = problem.linearise(w, &mut NormalEquations::zeros(w.len()))
        + alpha * w.iter().map(|w| w * w).sum::<f64>();
    let outcome = minimise(&mut problem, w, alpha, config, 300);
    assert!(w.iter().all(|w| w.is_finite()));
    assert!(
        outcome.cost <= start * (1.0 + 1e-9),
        "{start} rose to {}",
        outcome.cost
    );
    assert!(outcome.iterations <= 330);
    outcome
}

/// From the teacher's neighbourhood the teacher is found again, to rounding: residuals of zero
/// have no curvature of their own, so the steps end quadratically.
#[test]
fn an_exact_teacher_is_found() {
    let taught = Taught::new();
    let away = random(&taught.shape, 5, 0.05);
    let mut w: Vec<f64> = taught
        .teacher
        .iter()
        .zip(&away)
        .map(|(t, a)| t + a)
        .collect();
    let outcome = descend(&mut w, LmConfig::default(), 0.0);
    assert!(outcome.cost < 1e-20, "{outcome:?}");
    // and at the teacher itself there is nothing to do
    let mut w = taught.teacher.clone();
    let outcome = descend(&mut w, LmConfig::default(), 0.0);
    assert!(
        outcome.cost < 1e-25 && outcome.iterations <= 1,
        "{outcome:?}"
    );
}

/// Two equal units have equal columns: JᵀJ is singular, the damping keeps the step defined and
/// moves both alike, until rounding parts them.
#[test]
fn duplicated_hidden_units() {
    let shape = Taught::new().shape;
    let mut w = random(&shape, 2, 0.6);
    let (inputs, second) = (4, shape.offsets()[1]);
    for i in 0..inputs {
        w[inputs + i] = w[i];
    }
    for unit in 0..4 {
        w[second + unit * 7 + 2] = w[second + unit * 7 + 1];
    }
    let outcome = descend(&mut w, LmConfig::default(), 0.0);
    // as good as a net of one unit less: a thousandth of the targets' own square
    let taught = Taught::new();
    let mean_only = taught.problem().cost(&vec![0.0; w.len()]);
    assert!(outcome.cost < 1e-3 * mean_only, "{outcome:?}, {mean_only}");
}

/// At ±50 and ±1,000 the hidden units are steps and their derivatives zero or nearly so. Damped
/// by a multiple of I such weights rest while the output layer is fitted.
#[test]
fn weights_started_at_50_and_1000() {
    let shape = Taught::new().shape;
    for size in [50.0, 1000.0] {
        let mut w: Vec<f64> = random(&shape, 3, 1.0)
            .iter()
            .map(|w| size * w.signum())
            .collect();
        let before = w.clone();
        let outcome = descend(&mut w, LmConfig::default(), 0.0);
        assert_ne!(w, before);
        let per_value = outcome.cost / (3 * ROWS) as f64;
        assert!(per_value < 1.0, "{size}: {outcome:?}");
        if size == 1000.0 {
            let hidden = shape.offsets()[2];
            assert_eq!(w[..hidden], before[..hidden]);
        }
        // weight decay draws them back to where they can learn
        let mut decayed = before.clone();
        descend(&mut decayed, LmConfig::default(), 1e-3);
        let largest = decayed.iter().fold(0.0f64, |m, w| m.max(w.abs()));
        assert!(largest < size, "{largest}");
    }
}

/// λ diag(JᵀJ), as Marquardt wrote it, leaves a unit of zero derivatives undamped: no λ makes
/// the matrix regular, and the fit cannot take a step. Clamped from below, or with Moré's memory,
/// it can.
#[test]
fn marquardts_scaling_fails_on_saturated_units() {
    let shape = Taught::new().shape;
    let start: Vec<f64> = random(&shape, 3, 1.0)
        .iter()
        .map(|w| 1000.0 * w.signum())
        .collect();
    let step = |scaling| {
        let taught = Taught::new();
        let config = LmConfig {
            scaling,
            ..LmConfig::default()
        };
        let mut w = start.clone();
        Solver::new(w.len(), config).step(&mut taught.problem(), &mut w, 0.0)
    };
    assert_eq!(step(Scaling::Marquardt), Err(Termination::Damping));
    for scaling in [
        Scaling::Identity,
        Scaling::More,
        Scaling::Clamped { floor: 1e-6 },
    ] {
        assert!(step(scaling).is_ok(), "{scaling:?}");
    }
}

/// A start whose cost is not finite is refused.
#[test]
fn a_start_that_is_not_finite() {
    let taught = Taught::new();
    let mut w = taught.teacher.clone();
    w[0] = f64::NAN;
    let stop = Solver::new(w.len(), LmConfig::default()).step(&mut taught.problem(), &mut w, 0.0);
    assert_eq!(stop, Err(Termination::NotFinite));
}
