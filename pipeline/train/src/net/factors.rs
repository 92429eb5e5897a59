//! What a pair of layers contributes to JᵀWJ on one tile, as the two factors of a matrix product.

use crate::net::products::{Packed, Real, STEP};
use crate::net::simd::TILE_ROWS;
use crate::net::tile::{CHANNELS, Tile};

/// Room for the factors of all pairs of layers.
pub(crate) struct Factors<T> {
    /// Lowest layer that is read.
    first: usize,
    sizes: Vec<usize>,
    /// Row-major copies `[row][1, z_1, ...]` of the inputs of each layer.
    z: Vec<Packed<T>>,
    /// Row-major copies of the gradients of each layer, one channel after the other.
    g: Vec<Packed<T>>,
    a: Vec<T>,
    b: Vec<T>,
}

impl<T: Real> Factors<T> {
    /// For tiles like this one, from layer `first` on; `lda` and `ldb` are the widest factors.
    pub fn new(tile: &Tile, first: usize, lda: usize, ldb: usize) -> Factors<T> {
        let (sizes, top) = (tile.sizes.clone(), tile.depth());
        Factors {
            z: (0..=top)
                .map(|l| Packed::new(sizes[l] + 1).with_ones())
                .collect(),
            g: (0..top)
                .map(|l| Packed::new(CHANNELS * sizes[l + 1]))
                .collect(),
            a: vec![T::default(); lda * TILE_ROWS + STEP],
            b: vec![T::default(); ldb * TILE_ROWS + STEP],
            first,
            sizes,
        }
    }

    /// Row-major copies of what the products read.
    pub fn pack(&mut self, tile: &Tile) {
        for (l, z) in self.z.iter_mut().enumerate().skip(self.first) {
            z.set(1, tile.input_of(l));
        }
        for (l, g) in self.g.iter_mut().enumerate().skip(self.first) {
            g.set(0, &tile.g[l]);
        }
    }

    /// Adds the product of one pair of layers, p at least q, to `sums`: of pairs of units and pairs of
    /// inputs, or of pairs of inputs and pairs of units where `swapped`.
    pub fn add(
        &mut self,
        tile: &Tile,
        [p, q]: [usize; 2],
        [lda, ldb]: [usize; 2],
        swapped: bool,
        sums: &mut [f64],
    ) {
        let (top, rows) = (tile.depth(), tile.batch.rows);
        let (a, b, n) = (&mut self.a, &mut self.b, &self.sizes);
        let ((units, ldu), (inputs, ldi)) = if swapped {
            ((b, ldb), (a, lda))
        } else {
            ((a, lda), (b, ldb))
        };
        if p == q {
            T::upper(&self.z[p], n[p] + 1, rows, ldi, inputs);
        } else {
            let [y, z] = [p, q].map(|l| (&self.z[l], n[l] + 1));
            T::outer(y, z, rows, ldi, inputs);
        }
        if q == top {
            for (row, a) in units.chunks_exact_mut(ldu).take(rows).enumerate() {
                for (a, s) in a.iter_mut().zip(&tile.s) {
                    *a = T::of(s[row] * s[row]);
                }
            }
        } else if p == top {
            for (row, a) in units.chunks_exact_mut(ldu).take(rows).enumerate() {
                for c in 0..CHANNELS {
                    let s = T::of(tile.s[c][row]);
                    let g = &self.g[q].row(row)[c * n[q + 1]..][..n[q + 1]];
                    for (a, g) in a[c * n[q + 1]..].iter_mut().zip(g) {
                        *a = s.times(*g);
                    }
                }
            }
        } else {
            let [y, z] = [p, q].map(|l| (&self.g[l], n[l + 1]));
            T::over_channels(y, z, p == q, rows, ldu, units);
        }
        T::accumulate(&self.a[..rows * lda], lda, &self.b[..rows * ldb], ldb, sums);
    }
}
