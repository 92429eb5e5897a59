//! NIST StRD nonlinear regression: 27 sets, both starts, certified to 11 digits.

use crate::dual::Dual;
use crate::models::{MODELS, Model};
use rrf_lm::{Dense, LmConfig, Residuals, Scaling, minimise};
use std::path::Path;

struct Set {
    starts: [Vec<f64>; 2],
    certified: Vec<f64>,
    /// Response, then predictors.
    data: Vec<Vec<f64>>,
    model: Model,
}

/// Reads starts, certified values and data by the layout that the files share.
fn read(name: &str, logarithm: bool, model: Model) -> Set {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../tests/data/nist")
        .join(format!("{name}.dat"));
    let text = std::fs::read_to_string(&path).unwrap();
    let mut set = Set {
        starts: [vec![], vec![]],
        certified: vec![],
        data: vec![],
        model,
    };
    let mut in_data = false;
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        let numbers: Vec<f64> = words.iter().filter_map(|w| w.parse().ok()).collect();
        let is_parameter = words.first().is_some_and(|w| w.starts_with('b'));
        if in_data && numbers.len() == words.len() && numbers.len() >= 2 {
            let mut row = numbers;
            if logarithm {
                row[0] = row[0].ln();
            }
            set.data.push(row);
        } else if is_parameter && words.get(1) == Some(&"=") && numbers.len() == 4 {
            set.starts[0].push(numbers[0]);
            set.starts[1].push(numbers[1]);
            set.certified.push(numbers[2]);
        }
        // The header names the block of lines too; the data begin at the second "Data:" with y.
        in_data |= words.first() == Some(&"Data:") && words.get(1) == Some(&"y");
    }
    let stated = text
        .lines()
        .find_map(|l| l.trim().strip_prefix("Number of Observations:"))
        .map(|n| n.trim().parse().unwrap());
    assert_eq!(stated, Some(set.data.len()), "{name}: rows");
    assert!(!set.certified.is_empty());
    set
}

impl Set {
    fn each(&self, w: &[f64], mut see: impl FnMut(usize, Dual)) {
        let b: Vec<Dual> = (w.iter().enumerate())
            .map(|(i, v)| Dual::parameter(*v, i))
            .collect();
        for (row, data) in self.data.iter().enumerate() {
            see(row, (self.model)(&b, &data[1..]) - data[0]);
        }
    }
}

impl Residuals for &Set {
    fn parameters(&self) -> usize {
        self.certified.len()
    }

    fn residuals(&self) -> usize {
        self.data.len()
    }

    fn evaluate(&self, w: &[f64], r: &mut [f64]) {
        self.each(w, |row, value| r[row] = value.v);
    }

    fn jacobian(&self, w: &[f64], j: &mut [f64]) {
        let n = w.len();
        self.each(w, |row, value| {
            j[row * n..][..n].copy_from_slice(&value.d[..n])
        });
    }
}

/// Digits that agree in the worst parameter: −log10 of the relative error, at most 11.
fn digits(w: &[f64], certified: &[f64]) -> f64 {
    let worst = (w.iter().zip(certified))
        .map(|(w, c)| ((w - c) / c).abs())
        .fold(0.0, f64::max);
    if worst.is_nan() {
        0.0
    } else {
        (-worst.log10()).clamp(0.0, 11.0)
    }
}

/// At least 53 of the 54 runs reach 6 digits in every parameter and 45 reach 8. MINPACK's LM
/// through SciPy, at its tightest tolerances with exact Jacobians, does 53 and 40.
#[test]
fn certified_values() {
    let config = LmConfig {
        scaling: Scaling::More,
        ..LmConfig::exact()
    };
    let mut reached = Vec::new();
    for (name, logarithm, model) in MODELS {
        let set = read(name, logarithm, model);
        for (start, from) in set.starts.iter().enumerate() {
            let mut w = from.clone();
            let outcome = minimise(&mut Dense::new(&set), &mut w, 0.0, config, 5_000);
            let digits = digits(&w, &set.certified);
            println!(
                "{name:10} start {} {digits:5.1} digits, {:4} steps, {:?}",
                start + 1,
                outcome.iterations,
                outcome.termination
            );
            reached.push(digits);
        }
    }
    let count = |least: f64| reached.iter().filter(|d| **d >= least).count();
    let (six, eight) = (count(6.0), count(8.0));
    println!(
        "of {} runs {six} reach 6 digits, {eight} reach 8",
        reached.len()
    );
    assert_eq!(reached.len(), 54);
    assert!(
        six >= 53 && eight >= 45,
        "{six} with 6 digits, {eight} with 8"
    );
}
