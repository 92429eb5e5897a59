//! Baselines against dumber ones.

use super::nearest::{NEIGHBOURS, Nearest};
use super::probes::{Grid, HARMONICS, Probes, corners, harmonics};
use super::quadratic::{self, Quadratic};
use rrf_sampling::{Stage, Stream};

fn numbers(count: usize, of: u32) -> Vec<f32> {
    let mut random = Stream::new(5, Stage::Test, of).dimensions(0);
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

/// Products of two harmonics have degree four at most: five Gauss-Legendre nodes along z and eight
/// angles around it integrate them exactly.
#[test]
fn harmonics_are_orthonormal() {
    let (a, b) = (2.0 * (10.0f64 / 7.0).sqrt(), 13.0 * 70f64.sqrt());
    let nodes = [
        (0.0, 128.0 / 225.0),
        ((5.0 - a).sqrt() / 3.0, (322.0 + b) / 900.0),
        (-(5.0 - a).sqrt() / 3.0, (322.0 + b) / 900.0),
        ((5.0 + a).sqrt() / 3.0, (322.0 - b) / 900.0),
        (-(5.0 + a).sqrt() / 3.0, (322.0 - b) / 900.0),
    ];
    let mut sums = [[0.0; HARMONICS]; HARMONICS];
    for (z, weight) in nodes {
        for k in 0..8 {
            let (around, r) = (k as f64 * std::f64::consts::FRAC_PI_4, (1.0 - z * z).sqrt());
            let y = harmonics([r * around.cos(), r * around.sin(), z]);
            for (i, sums) in sums.iter_mut().enumerate() {
                for (j, sum) in sums.iter_mut().enumerate() {
                    *sum += weight * std::f64::consts::FRAC_PI_4 * y[i] * y[j];
                }
            }
        }
    }
    for (i, sums) in sums.iter().enumerate() {
        for (j, sum) in sums.iter().enumerate() {
            assert!(
                (sum - f64::from(u8::from(i == j))).abs() < 1e-14,
                "{i} {j}: {sum}"
            );
        }
    }
}

/// The constants of Ramamoorthi, Hanrahan 2001, eq. 3.
#[test]
fn harmonics_are_those_of_the_paper() {
    let [x, y, z] = [0.36, 0.48, 0.8];
    let wanted = [
        0.282095,
        0.488603 * y,
        0.488603 * z,
        0.488603 * x,
        1.092548 * x * y,
        1.092548 * y * z,
        0.315392 * (3.0 * z * z - 1.0),
        1.092548 * x * z,
        0.546274 * (x * x - y * y),
    ];
    for (found, wanted) in harmonics([x, y, z]).into_iter().zip(wanted) {
        // given to six digits
        assert!((found - wanted).abs() < 2e-6, "{found} {wanted}");
    }
}

/// Shares add up to one and to the place itself; beyond the grid to the nearest on its border.
#[test]
fn shares_are_trilinear() {
    for count in [2, 6] {
        let last = count as f64 - 1.0;
        for x in numbers(300, 8).chunks(3) {
            let x: [f64; 3] = std::array::from_fn(|i| last * (0.5 + 0.7 * f64::from(x[i])));
            let (ids, shares) = corners(x, count);
            assert!(shares.iter().all(|share| (0.0..=1.0).contains(share)));
            assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-15 * 8.0);
            for (axis, x) in x.into_iter().enumerate() {
                let at = |id: usize| (id / count.pow(2 - axis as u32) % count) as f64;
                let place: f64 = ids.iter().zip(shares).map(|(id, s)| s * at(*id)).sum();
                assert!((place - x.clamp(0.0, last)).abs() < 1e-14);
            }
        }
    }
}

/// Coefficients that are values of a field linear along every axis: the probes give the field.
#[test]
fn probes_follow_what_is_trilinear() {
    let grid = Grid {
        places: 3,
        lights: 2,
    };
    let place = |x: f64, y: f64, z: f64| 1.0 + x - 2.0 * y + 0.5 * x * z;
    let light = |x: f64, y: f64, z: f64| 2.0 + 0.3 * y * z - x;
    let mut weights = Vec::new();
    for p in 0..27 {
        for l in 0..8 {
            let of = |id: usize, n: usize| [id / (n * n), id / n % n, id % n].map(|x| x as f64);
            let ([x, y, z], [u, v, w]) = (of(p, 3), of(l, 2));
            let value = place(x, y, z) * light(u, v, w);
            weights.extend((0..3 * HARMONICS).map(|k| (value * (k as f64 - 5.0)) as f32));
        }
    }
    let probes = Probes::new(grid, &weights);
    for x in numbers(90, 9).chunks(9) {
        let x: Vec<f32> = x.iter().map(|x| 0.5 + 0.5 * x).collect();
        let at = |i: usize| f64::from(x[i]);
        let value = place(at(0), at(1), at(2)) * light(at(6), at(7), at(8));
        let y = harmonics([at(3), at(4), at(5)]);
        let found = probes.answer(&x);
        for (c, found) in found.into_iter().enumerate() {
            let wanted: f64 = (0..HARMONICS)
                .map(|h| (3 * h + c) as f64 - 5.0)
                .zip(y)
                .map(|(w, y)| w * y)
                .sum();
            // coefficients are rounded to f32
            assert!(
                (found - value * wanted).abs() < 1e-5,
                "{found} {}",
                value * wanted
            );
        }
    }
    assert_eq!(
        Grid {
            places: 1,
            lights: 2
        }
        .coefficients(),
        None
    );
    assert_eq!(
        Grid {
            places: usize::MAX,
            lights: 2
        }
        .coefficients(),
        None
    );
}
