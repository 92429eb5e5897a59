//! Sums over a model's numbers for one light, several at a time.
//!
//! No operation is fused and sums run in a fixed order, so that bits do not depend on the processor.

use glam::Vec3;
use multiversion::multiversion;

/// Sums that run side by side: a multiple of three channels.
const SIDE: usize = 12;

/// Adds to each combination what its weights make of the fluxes of some nodes: `weights` is of
/// shape [nodes, rank] row-major.
pub(super) fn combine(rank: usize, nodes: &[u32], weights: &[f32], fluxes: &[Vec3]) -> Vec<Vec3> {
    let flux = |node: u32| fluxes.get(node as usize).copied().unwrap_or_default();
    let is_white = |&node: &u32| {
        let flux = flux(node);
        flux.x == flux.y && flux.y == flux.z
    };
    let mut sums = vec![0.0f32; rank];
    let mut combined = vec![Vec3::ZERO; rank];
    if nodes.iter().all(is_white) {
        let own: Vec<f32> = nodes.iter().map(|&node| flux(node).x).collect();
        add_rows(&own, weights, &mut sums);
        (combined.iter_mut().zip(&sums)).for_each(|(c, &s)| *c = Vec3::splat(s));
        return combined;
    }
    for channel in 0..3 {
        let own: Vec<f32> = nodes.iter().map(|&node| flux(node)[channel]).collect();
        sums.fill(0.0);
        add_rows(&own, weights, &mut sums);
        (combined.iter_mut().zip(&sums)).for_each(|(c, &s)| c[channel] = s);
    }
    combined
}

/// Adds rows of a matrix, each by its factor.
#[multiversion(targets("x86_64+avx+avx2+fma+avx512f+avx512vl", "x86_64+avx+avx2+fma"))]
fn add_rows(factors: &[f32], matrix: &[f32], sums: &mut [f32]) {
    let rows = matrix.chunks_exact(sums.len().max(1));
    for (&factor, row) in factors.iter().zip(rows) {
        sums.iter_mut().zip(row).for_each(|(s, w)| *s += factor * w);
    }
}

/// The rows of a matrix of shape [rows, rank, 3] times the coefficients, channel by channel.
pub(super) fn contract(matrix: &[f32], coefficients: &[Vec3]) -> Vec<Vec3> {
    let flat: Vec<f32> = coefficients.iter().flat_map(Vec3::to_array).collect();
    let mut contracted = Vec::with_capacity(matrix.len() / flat.len().max(1));
    contract_rows(matrix, &flat, &mut contracted);
    contracted
}

#[multiversion(targets("x86_64+avx+avx2+fma+avx512f+avx512vl", "x86_64+avx+avx2+fma"))]
fn contract_rows(matrix: &[f32], flat: &[f32], contracted: &mut Vec<Vec3>) {
    let (whole, rest) = flat.as_chunks::<SIDE>();
    for row in matrix.chunks_exact(flat.len().max(1)) {
        let mut sums = [0.0f32; SIDE];
        let (own, left) = row.as_chunks::<SIDE>();
        for (w, c) in own.iter().zip(whole) {
            for i in 0..SIDE {
                sums[i] += w[i] * c[i];
            }
        }
        for (i, (w, c)) in left.iter().zip(rest).enumerate() {
            sums[i] += w * c;
        }
        let channel = |c: usize| (sums[c] + sums[c + 3]) + (sums[c + 6] + sums[c + 9]);
        contracted.push(Vec3::new(channel(0), channel(1), channel(2)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sums of numbers that single precision holds are those of plain loops; white lights, which are
    /// summed once, and lights of three colours.
    #[test]
    fn sums_are_those_of_plain_loops() {
        let number = |i: usize| ((i * 7919) % 23) as f32 - 11.0;
        for rank in [1, 5, 8, 17] {
            let nodes = [4, 0, 3];
            let weights: Vec<f32> = (0..3 * rank).map(number).collect();
            for white in [true, false] {
                let colour = |i: usize| Vec3::from([0, 1, 2].map(|c| number(3 * i + c)));
                let flux = |i: usize| {
                    if white {
                        Vec3::splat(number(i))
                    } else {
                        colour(i)
                    }
                };
                // the last node lies beyond what is lit
                let fluxes: Vec<Vec3> = (0..4).map(flux).collect();
                let found = combine(rank, &nodes, &weights, &fluxes);
                for (k, found) in found.iter().enumerate() {
                    let sum = fluxes[0] * weights[rank + k] + fluxes[3] * weights[2 * rank + k];
                    assert_eq!(*found, sum);
                }
            }
            let matrix: Vec<f32> = (0..4 * 3 * rank).map(number).collect();
            let light: Vec<Vec3> = (0..rank).map(|k| Vec3::splat(number(k + 5))).collect();
            for (row, found) in contract(&matrix, &light).iter().enumerate() {
                let own = |k: usize| Vec3::from_slice(&matrix[3 * (row * rank + k)..]);
                let sum: Vec3 = (0..rank).map(|k| own(k) * light[k]).sum();
                assert_eq!(*found, sum);
            }
        }
    }
}
