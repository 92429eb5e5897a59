//! Sums over a model's packed numbers for one light, several at a time.
//!
//! No operation is fused and sums run in a fixed order, so that bits do not depend on the processor.

use super::packed::{PackedNumber, PackedRows};
use glam::Vec3;
use multiversion::multiversion;

/// Sums that run side by side: a multiple of three channels.
const SIDE: usize = 12;

/// Adds to each combination what its weights make of the fluxes of some nodes: `weights` has a row a node.
pub(super) fn combine(nodes: &[u32], weights: &PackedRows, fluxes: &[Vec3]) -> Vec<Vec3> {
    let rank = weights.width;
    let flux = |node: u32| fluxes.get(node as usize).copied().unwrap_or_default();
    let is_white = |&node: &u32| {
        let flux = flux(node);
        flux.x == flux.y && flux.y == flux.z
    };
    let scaled = |of: &dyn Fn(u32) -> f32| -> Vec<f32> {
        let rows = nodes.iter().zip(&weights.scales);
        rows.map(|(&node, scale)| of(node) * scale).collect()
    };
    let mut sums = vec![0.0f32; rank];
    let mut combined = vec![Vec3::ZERO; rank];
    if nodes.iter().all(is_white) {
        add_rows(&scaled(&|node| flux(node).x), &weights.values, &mut sums);
        (combined.iter_mut().zip(&sums)).for_each(|(c, &s)| *c = Vec3::splat(s));
        return combined;
    }
    for channel in 0..3 {
        sums.fill(0.0);
        let own = scaled(&|node| flux(node)[channel]);
        add_rows(&own, &weights.values, &mut sums);
        (combined.iter_mut().zip(&sums)).for_each(|(c, &s)| c[channel] = s);
    }
    combined
}

/// Adds rows of a matrix, each by its factor.
#[multiversion(targets("x86_64+avx+avx2+fma+avx512f+avx512vl", "x86_64+avx+avx2+fma"))]
fn add_rows(factors: &[f32], matrix: &[i8], sums: &mut [f32]) {
    let rows = matrix.chunks_exact(sums.len().max(1));
    for (&factor, row) in factors.iter().zip(rows) {
        let pairs = sums.iter_mut().zip(row);
        pairs.for_each(|(s, &w)| *s += factor * f32::from(w));
    }
}

/// The rows of a matrix of shape [rows, rank, 3] times the coefficients, channel by channel.
pub(super) fn contract<T: PackedNumber>(
    matrix: &PackedRows<T>,
    coefficients: &[Vec3],
) -> Vec<Vec3> {
    let flat: Vec<f32> = coefficients.iter().flat_map(Vec3::to_array).collect();
    let mut contracted = Vec::with_capacity(matrix.rows());
    contract_rows(&matrix.values, &flat, &mut contracted);
    let rows = contracted.iter_mut().zip(&matrix.scales);
    rows.for_each(|(row, scale)| *row *= *scale);
    contracted
}

#[multiversion(targets("x86_64+avx+avx2+fma+avx512f+avx512vl", "x86_64+avx+avx2+fma"))]
fn contract_rows<T: PackedNumber>(matrix: &[T], flat: &[f32], contracted: &mut Vec<Vec3>) {
    let (whole, rest) = flat.as_chunks::<SIDE>();
    for row in matrix.chunks_exact(flat.len().max(1)) {
        let mut sums = [0.0f32; SIDE];
        let (own, left) = row.as_chunks::<SIDE>();
        for (w, c) in own.iter().zip(whole) {
            for i in 0..SIDE {
                let w: f32 = w[i].into();
                sums[i] += w * c[i];
            }
        }
        for (i, (&w, c)) in left.iter().zip(rest).enumerate() {
            let w: f32 = w.into();
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
        let packed = |rows: usize, width: usize| PackedRows {
            width,
            scales: (0..rows).map(|row| [1.0, 0.5, 2.0][row % 3]).collect(),
            values: (0..rows * width).map(|i| number(i) as i8).collect(),
        };
        for rank in [1, 5, 8, 17] {
            let nodes = [4, 0, 3];
            let weights = packed(3, rank);
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
                let found = combine(&nodes, &weights, &fluxes);
                for (k, found) in found.iter().enumerate() {
                    let sum =
                        fluxes[0] * 0.5 * number(rank + k) + fluxes[3] * 2.0 * number(2 * rank + k);
                    assert_eq!(*found, sum);
                }
            }
            let matrix = packed(4, 3 * rank);
            let light: Vec<Vec3> = (0..rank).map(|k| Vec3::splat(number(k + 5))).collect();
            for (row, found) in contract(&matrix, &light).iter().enumerate() {
                let own =
                    |k: usize| Vec3::from([0, 1, 2].map(|c| number(3 * (row * rank + k) + c)));
                let sum: Vec3 = (0..rank).map(|k| own(k) * light[k]).sum();
                assert_eq!(*found, sum * matrix.scales[row]);
            }
        }
    }
}
