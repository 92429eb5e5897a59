//! Sparse regression: a target as the sum of a few columns out of many, by greedy regularised least squares.

/// Most points of one lamp.
const MOST_POINTS: usize = 12;
/// Relative error of a net that large intensities are weighed against.
const NET_ERROR: f64 = 0.05;
/// A point has to lessen the objective by this share of the lamp's own norm.
const WORTHWHILE: f64 = 2e-4;

/// The chosen columns with their factors.
pub fn fit_sparse(target: &[f64], columns: &[Vec<f64>]) -> Vec<(usize, f64)> {
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let norm = product(target, target);
    let right: Vec<f64> = columns.iter().map(|c| product(c, target)).collect();
    let gram = |i: usize, j: usize| {
        let ridge = if i == j {
            1.0 + NET_ERROR * NET_ERROR
        } else {
            1.0
        };
        ridge * product(&columns[i], &columns[j])
    };
    let table: Vec<Vec<f64>> = (0..columns.len())
        .map(|i| (0..columns.len()).map(|j| gram(i, j)).collect())
        .collect();
    let mut best: (Vec<(usize, f64)>, f64) = (Vec::new(), norm);
    while best.0.len() < MOST_POINTS && norm > 0.0 {
        let mut next = best.clone();
        for candidate in 0..columns.len() {
            let mut set: Vec<usize> = best.0.iter().map(|&(k, _)| k).collect();
            if set.contains(&candidate) {
                continue;
            }
            set.push(candidate);
            let Some(factors) = solve(&table, &right, &set) else {
                continue;
            };
            // at the least-squares solution: norm - factors . right
            let gained: f64 = set.iter().zip(&factors).map(|(&k, c)| c * right[k]).sum();
            if norm - gained < next.1 {
                next = (set.into_iter().zip(factors).collect(), norm - gained);
            }
        }
        if best.1 - next.1 < WORTHWHILE * norm {
            break;
        }
        best = next;
    }
    best.0
}

/// Solves the rows and columns `set` of a symmetric positive definite system by Cholesky;
/// none where rounding has made it indefinite.
fn solve(table: &[Vec<f64>], right: &[f64], set: &[usize]) -> Option<Vec<f64>> {
    let n = set.len();
    let mut lower = vec![vec![0.0; n]; n];
    for i in 0..n {
        for j in 0..=i {
            let dot: f64 = (0..j).map(|k| lower[i][k] * lower[j][k]).sum();
            let value = table[set[i]][set[j]] - dot;
            if i == j {
                if value.is_nan() || value <= 1e-12 * table[set[i]][set[i]] {
                    return None;
                }
                lower[i][i] = value.sqrt();
            } else {
                lower[i][j] = value / lower[j][j];
            }
        }
    }
    let mut x: Vec<f64> = set.iter().map(|&k| right[k]).collect();
    for i in 0..n {
        let dot: f64 = (0..i).map(|k| lower[i][k] * x[k]).sum();
        x[i] = (x[i] - dot) / lower[i][i];
    }
    for i in (0..n).rev() {
        let dot: f64 = (i + 1..n).map(|k| lower[k][i] * x[k]).sum();
        x[i] = (x[i] - dot) / lower[i][i];
    }
    Some(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sum_of_two_columns_is_found_again() {
        let wave = |k: usize| -> Vec<f64> {
            (0..200)
                .map(|i| ((i * (k + 1)) as f64 * 0.37).sin() + 1.5)
                .collect()
        };
        let columns: Vec<Vec<f64>> = (0..6).map(wave).collect();
        let sum = |a: &f64, b: &f64| 2.0 * a - 0.5 * b;
        let target: Vec<f64> = columns[1]
            .iter()
            .zip(&columns[4])
            .map(|(a, b)| sum(a, b))
            .collect();
        let chosen = fit_sparse(&target, &columns);
        let factor = |k: usize| chosen.iter().find(|c| c.0 == k).map_or(0.0, |c| c.1);
        // to the ridge, which takes a little of each
        assert!(
            (factor(1) - 2.0).abs() < 0.1 && (factor(4) + 0.5).abs() < 0.1,
            "{chosen:?}"
        );
    }

    /// Against the definition: A x = b.
    #[test]
    fn solves_what_it_is_given() {
        let table = vec![
            vec![4.0, 1.0, 0.5],
            vec![1.0, 3.0, -0.2],
            vec![0.5, -0.2, 2.0],
        ];
        let right = [1.0, -2.0, 0.3];
        let x = solve(&table, &right, &[0, 1, 2]).unwrap();
        for (row, b) in table.iter().zip(right) {
            let ax: f64 = row.iter().zip(&x).map(|(a, x)| a * x).sum();
            assert!((ax - b).abs() < 1e-12);
        }
        assert!(solve(&[vec![0.0]], &[1.0], &[0]).is_none());
    }
}
