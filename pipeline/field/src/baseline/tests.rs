//! Baselines against dumber ones.

use super::nearest::{NEIGHBOURS, Nearest};
use super::quadratic::{self, Quadratic};
use crate::rng::{Stage, Stream};

fn numbers(count: usize, of: u32) -> Vec<f32> {
    let mut random = Stream::new(5, Stage::Test, of).walk(0);
    (0..count).map(|_| 2.0 * random.next_f32() - 1.0).collect()
}

/// cᵀ [1 x] + xᵀ M x with M upper triangular, as a matrix product.
#[test]
fn a_quadratic_is_its_matrix() {
    for inputs in [0, 1, 2, 7] {
        let count = quadratic::count(inputs).unwrap();
        let weights = numbers(3 * count, 1);
        let model = Quadratic::new(&weights);
        let x = numbers(inputs, 2);
        let found = model.answer(&x, &mut Vec::new());
        for (c, found) in found.into_iter().enumerate() {
            let w = &weights[c * count..][..count];
            let mut matrix = vec![vec![0.0; inputs]; inputs];
            let mut rest = w[1 + inputs..].iter();
            for (i, row) in matrix.iter_mut().enumerate() {
                for m in &mut row[i..] {
                    *m = f64::from(*rest.next().unwrap());
                }
            }
            assert_eq!(rest.next(), None);
            let mut wanted = f64::from(w[0]);
            for i in 0..inputs {
                let row: f64 = (0..inputs).map(|j| matrix[i][j] * f64::from(x[j])).sum();
                wanted += f64::from(x[i]) * (f64::from(w[1 + i]) + row);
            }
            // sums of at most 36 terms below 1
            assert!((found - wanted).abs() < 36.0 * 36.0 * f64::EPSILON);
        }
    }
    assert_eq!(quadratic::count(usize::MAX), None);
}

/// All distances, sorted.
fn brute(inputs: usize, weights: &[f32], rows: usize, x: &[f32]) -> [f64; 3] {
    let square = |r: usize| -> f64 {
        let point = &weights[r * inputs..][..inputs];
        let squares = (0..inputs).map(|i| (f64::from(x[i]) - f64::from(point[i])).powi(2));
        squares.sum()
    };
    let mut order: Vec<(f64, usize)> = (0..rows).map(|r| (square(r), r)).collect();
    order.sort_by(|a, b| a.partial_cmp(b).unwrap());
    order.truncate(NEIGHBOURS);
    let on_it = order[0].0 == 0.0;
    order.retain(|(square, _)| !on_it || *square == 0.0);
    let weight = |square: f64| if on_it { 1.0 } else { 1.0 / square };
    let total: f64 = order.iter().map(|(s, _)| weight(*s)).sum();
    let value = |r: usize, c: usize| f64::from(weights[inputs * rows + 3 * r + c]);
    std::array::from_fn(|c| {
        order
            .iter()
            .map(|(s, r)| weight(*s) * value(*r, c))
            .sum::<f64>()
            / total
    })
}

/// On scattered rows, on rows of a coarse lattice (many as near), on rows that are all the same, on
/// fewer rows than neighbours: the tree finds what a search of all finds.
#[test]
fn the_tree_finds_the_nearest() {
    for (inputs, rows, lattice) in [
        (1, 1, 0.0),
        (2, 5, 0.0),
        (3, 700, 0.0),
        (9, 1500, 0.0),
        (4, 900, 2.0),
        (3, 100, 0.4),
        (2, 60, 0.0),
    ] {
        let mut weights = numbers((inputs + 3) * rows, 3);
        for x in &mut weights[..inputs * rows] {
            if lattice > 0.0 {
                *x = (*x * lattice).round();
            }
        }
        let model = Nearest::new(inputs, rows, &weights);
        let queries = numbers(200 * inputs, 4);
        for x in queries.chunks(inputs) {
            let lattice = |x: f32| (2.0 * x).round();
            for x in [x.to_vec(), x.iter().map(|&x| lattice(x)).collect()] {
                let (found, wanted) = (
                    model.answer(&x, &mut Vec::new()),
                    brute(inputs, &weights, rows, &x),
                );
                for (found, wanted) in found.into_iter().zip(wanted) {
                    assert!((found - wanted).abs() < 1e-13, "{found} {wanted}");
                }
            }
        }
    }
}

#[test]
fn a_row_answers_with_its_value() {
    let (inputs, rows) = (5, 400);
    let weights = numbers((inputs + 3) * rows, 6);
    let model = Nearest::new(inputs, rows, &weights);
    for r in 0..rows {
        let found = model.answer(&weights[r * inputs..][..inputs], &mut Vec::new());
        let value = &weights[inputs * rows + 3 * r..][..3];
        assert_eq!(found.map(|y| y as f32), *value);
    }
}
