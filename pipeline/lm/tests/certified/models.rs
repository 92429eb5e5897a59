//! The models of the NIST StRD nonlinear regression sets, as their files state them.

use crate::dual::Dual;
use std::f64::consts::PI;

/// y(x; b); x holds the predictors in the file's order.
pub type Model = fn(&[Dual], &[f64]) -> Dual;

/// Data set, whether the file's response is fitted as its logarithm, model.
pub const MODELS: [(&str, bool, Model); 27] = [
    ("Bennett5", false, |b, x| {
        b[0] * (b[1] + x[0]).pow(-1.0 / b[2])
    }),
    ("BoxBOD", false, saturation),
    ("Chwirut1", false, chwirut),
    ("Chwirut2", false, chwirut),
    ("DanWood", false, |b, x| b[0] * Dual::from(x[0]).pow(b[1])),
    ("ENSO", false, enso),
    ("Eckerle4", false, |b, x| {
        b[0] / b[1] * (-0.5 * ((x[0] - b[2]) / b[1]).square()).exp()
    }),
    ("Gauss1", false, gauss),
    ("Gauss2", false, gauss),
    ("Gauss3", false, gauss),
    ("Hahn1", false, cubic_over_cubic),
    ("Kirby2", false, |b, x| {
        (b[0] + b[1] * x[0] + b[2] * (x[0] * x[0])) / (1.0 + b[3] * x[0] + b[4] * (x[0] * x[0]))
    }),
    ("Lanczos1", false, lanczos),
    ("Lanczos2", false, lanczos),
    ("Lanczos3", false, lanczos),
    ("MGH09", false, |b, x| {
        let x = x[0];
        b[0] * (x * x + x * b[1]) / (x * x + x * b[2] + b[3])
    }),
    ("MGH10", false, |b, x| b[0] * (b[1] / (x[0] + b[2])).exp()),
    ("MGH17", false, |b, x| {
        b[0] + b[1] * (-x[0] * b[3]).exp() + b[2] * (-x[0] * b[4]).exp()
    }),
    ("Misra1a", false, saturation),
    ("Misra1b", false, |b, x| {
        b[0] * (1.0 - 1.0 / (1.0 + b[1] * x[0] / 2.0).square())
    }),
    ("Misra1c", false, |b, x| {
        b[0] * (1.0 - 1.0 / (1.0 + 2.0 * b[1] * x[0]).sqrt())
    }),
    ("Misra1d", false, |b, x| {
        b[0] * b[1] * x[0] / (1.0 + b[1] * x[0])
    }),
    ("Nelson", true, |b, x| {
        b[0] - b[1] * x[0] * (-b[2] * x[1]).exp()
    }),
    ("Rat42", false, |b, x| {
        b[0] / (1.0 + (b[1] - b[2] * x[0]).exp())
    }),
    ("Rat43", false, |b, x| {
        b[0] / (1.0 + (b[1] - b[2] * x[0]).exp()).pow(1.0 / b[3])
    }),
    ("Roszman1", false, |b, x| {
        b[0] - b[1] * x[0] - (b[2] / (x[0] - b[3])).atan() / PI
    }),
    ("Thurber", false, cubic_over_cubic),
];

fn saturation(b: &[Dual], x: &[f64]) -> Dual {
    b[0] * (1.0 - (-b[1] * x[0]).exp())
}

fn chwirut(b: &[Dual], x: &[f64]) -> Dual {
    (-b[0] * x[0]).exp() / (b[1] + b[2] * x[0])
}

fn enso(b: &[Dual], x: &[f64]) -> Dual {
    let wave = |period: Dual, c: Dual, s: Dual| {
        let phase = 2.0 * PI * x[0] / period;
        c * phase.cos() + s * phase.sin()
    };
    b[0] + wave(12.0.into(), b[1], b[2]) + wave(b[3], b[4], b[5]) + wave(b[6], b[7], b[8])
}

fn gauss(b: &[Dual], x: &[f64]) -> Dual {
    let bell = |height: Dual, at: Dual, width: Dual| {
        height * (-((x[0] - at).square() / width.square())).exp()
    };
    b[0] * (-b[1] * x[0]).exp() + bell(b[2], b[3], b[4]) + bell(b[5], b[6], b[7])
}

fn cubic_over_cubic(b: &[Dual], x: &[f64]) -> Dual {
    let (x, x2, x3) = (x[0], x[0].powi(2), x[0].powi(3));
    (b[0] + b[1] * x + b[2] * x2 + b[3] * x3) / (1.0 + b[4] * x + b[5] * x2 + b[6] * x3)
}

fn lanczos(b: &[Dual], x: &[f64]) -> Dual {
    (0..3)
        .map(|k| b[2 * k] * (-b[2 * k + 1] * x[0]).exp())
        .fold(Dual::from(0.0), |sum, term| sum + term)
}
