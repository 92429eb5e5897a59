//! JᵀWJ and JᵀWr of a net without ever forming J.
//!
//! The derivative of output c by weight (j, a) of layer p is g^p_cj z^p_a, so the block of
//! JᵀWJ between layers p and q is, with g already holding the square root of the weight,
//!
//! ```text
//!   B[(j,a), (k,b)] = Σ_rows ( Σ_c g^p_cj g^q_ck ) ( z^p_a z^q_b )
//! ```
//!
//! The channels are summed first; what is left is one matrix product over the rows between
//! the pairs (j,k) and the pairs (a,b). Where p = q both sets of pairs are symmetric and only
//! the upper triangles are kept. The output layer is linear: its g_cj is s_c where c = j.

use crate::net::factors::Factors;
use crate::net::gemm::{PAD_A, PAD_B};
use crate::net::simd::{TILE_ROWS, TileLane, dot};
use crate::net::tile::{CHANNELS, Tile};
use rrf_lm::NormalEquations;
use serde::{Deserialize, Serialize};

/// Products of the layers p ≥ q over the rows: C = Aᵀ B, between pairs of units and pairs of inputs.
struct Block {
    p: usize,
    q: usize,
    /// How many pairs of units and of inputs.
    units: usize,
    inputs: usize,
    /// The pairs of inputs are the columns of A and those of units of B, not the other way round.
    swapped: bool,
    lda: usize,
    ldb: usize,
    sums: Vec<f64>,
}

/// What the numbers are that JᵀWJ is multiplied from. JᵀWr is always summed in f64.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Precision {
    /// f64.
    #[default]
    Double,
    /// f32 products and sums of [`TILE_ROWS`] rows, f64 from there on: some 1e-7 of the largest entries,
    /// which bends steps where the curvature is below that share of the largest. The gradient, the
    /// cost and thus the minimum are those of [`Precision::Double`].
    Single,
}

enum Products {
    Double(Factors<f64>),
    Single(Factors<f32>),
}

/// Sums the normal equations tile by tile.
pub struct Accumulator {
    /// Lowest weight layer whose weights are parameters; those below are held.
    first: usize,
    sizes: Vec<usize>,
    offsets: Vec<usize>,
    blocks: Vec<Block>,
    products: Products,
    /// JᵀWr of each layer, `[units, inputs + 1]`.
    gradients: Vec<Vec<f64>>,
}

fn triangle(n: usize) -> usize {
    n * (n + 1) / 2
}

impl Accumulator {
    /// Zero sums for all weights of nets of the tile's shape.
    pub fn new(tile: &Tile, precision: Precision) -> Accumulator {
        Accumulator::above(tile, 0, precision)
    }

    /// Zero sums for the weights of the output layer alone.
    pub fn output_layer(tile: &Tile) -> Accumulator {
        Accumulator::above(tile, tile.depth(), Precision::Double)
    }

    fn above(tile: &Tile, first: usize, precision: Precision) -> Accumulator {
        let (sizes, top) = (tile.sizes.clone(), tile.depth());
        let ext = |l: usize| sizes[l] + 1;
        let mut blocks = Vec::new();
        for p in first..=top {
            for q in first..=p {
                let (m, n) = match (p == top, q == top, p == q) {
                    (true, true, _) => (CHANNELS, triangle(ext(p))),
                    (true, false, _) => (CHANNELS * sizes[q + 1], ext(p) * ext(q)),
                    (false, _, true) => (triangle(sizes[p + 1]), triangle(ext(p))),
                    (false, _, false) => (sizes[p + 1] * sizes[q + 1], ext(p) * ext(q)),
                };
                blocks.push(Block::new(p, q, m, n));
            }
        }
        let widest = |f: fn(&Block) -> usize| blocks.iter().map(f).max().unwrap_or(0);
        let (lda, ldb) = (widest(|b| b.lda), widest(|b| b.ldb));
        Accumulator {
            products: match precision {
                Precision::Double => Products::Double(Factors::new(tile, first, lda, ldb)),
                Precision::Single => Products::Single(Factors::new(tile, first, lda, ldb)),
            },
            gradients: (0..=top)
                .map(|l| vec![0.0; if l < first { 0 } else { sizes[l + 1] * ext(l) }])
                .collect(),
            offsets: (tile.offsets.iter())
                .map(|offset| offset.saturating_sub(tile.offsets[first]))
                .collect(),
            first,
            sizes,
            blocks,
        }
    }

    /// Back to zero.
    pub fn clear(&mut self) {
        let blocks = self.blocks.iter_mut().map(|block| &mut block.sums);
        blocks
            .chain(&mut self.gradients)
            .for_each(|sums| sums.fill(0.0));
    }

    /// Adds the rows of a tile after its forward, residual and backward passes.
    pub fn add(&mut self, tile: &Tile) {
        self.add_gradients(tile);
        match &mut self.products {
            Products::Double(factors) => factors.pack(tile),
            Products::Single(factors) => factors.pack(tile),
        }
        for block in &mut self.blocks {
            let layers = [block.p, block.q];
            let widths = [block.lda, block.ldb];
            let sums = &mut block.sums;
            match &mut self.products {
                Products::Double(factors) => factors.add(tile, layers, widths, block.swapped, sums),
                Products::Single(factors) => factors.add(tile, layers, widths, block.swapped, sums),
            }
        }
    }

    fn add_gradients(&mut self, tile: &Tile) {
        let top = tile.depth();
        for (l, sums) in self.gradients.iter_mut().enumerate().skip(self.first) {
            let (units, width) = (self.sizes[l + 1], self.sizes[l] + 1);
            for (j, sums) in sums.chunks_exact_mut(width).enumerate() {
                // Σ_c r_c g_cj
                let mut u: TileLane = [0.0; TILE_ROWS];
                let mut add = |r: &TileLane, g: &TileLane| {
                    for ((u, r), g) in u.iter_mut().zip(r).zip(g) {
                        *u += r * g;
                    }
                };
                if l == top {
                    add(&tile.r[j], &tile.s[j]);
                } else {
                    for (c, r) in tile.r.iter().enumerate() {
                        add(r, &tile.g[l][c * units + j]);
                    }
                }
                sums[0] += dot(&u, &[1.0; TILE_ROWS]);
                for (sum, z) in sums[1..].iter_mut().zip(tile.input_of(l)) {
                    *sum += dot(&u, z);
                }
            }
        }
    }

    /// The sums as JᵀWr.
    fn finish_gradient(&self, gradient: &mut [f64]) {
        for (sums, offset) in self.gradients.iter().zip(&self.offsets).skip(self.first) {
            gradient[*offset..][..sums.len()].copy_from_slice(sums);
        }
    }

    /// The sums as full normal equations.
    pub fn finish(&self, normal: &mut NormalEquations) {
        let n = normal.n;
        self.finish_gradient(&mut normal.gradient);
        for block in &self.blocks {
            self.spread(block, normal);
        }
        for i in 0..n {
            for j in 0..i {
                normal.matrix[j * n + i] = normal.matrix[i * n + j];
            }
        }
    }

    /// Writes one block where row ≥ column.
    fn spread(&self, block: &Block, normal: &mut NormalEquations) {
        let Block { p, q, .. } = *block;
        let top = self.sizes.len() - 2;
        let (wp, wq) = (self.sizes[p] + 1, self.sizes[q] + 1);
        let n = normal.n;
        let at = |l: usize, width: usize, unit: usize, a: usize| self.offsets[l] + unit * width + a;
        let mut set = |row: usize, column: usize, value: f64| {
            let (row, column) = (row.max(column), row.min(column));
            normal.matrix[row * n + column] = value;
        };
        let value = |pair: usize, ab: usize| match block.swapped {
            false => block.sums[pair * block.ldb + ab],
            true => block.sums[ab * block.ldb + pair],
        };
        for pair in 0..block.units {
            if p != q {
                let (j, k) = (pair / self.sizes[q + 1], pair % self.sizes[q + 1]);
                for ab in 0..block.inputs {
                    set(
                        at(p, wp, j, ab / wq),
                        at(q, wq, k, ab % wq),
                        value(pair, ab),
                    );
                }
            } else {
                let (j, k) = if p == top {
                    (pair, pair)
                } else {
                    unpair(pair, self.sizes[p + 1])
                };
                let mut ab = 0;
                for a in 0..wp {
                    for b in a..wp {
                        set(at(p, wp, j, a), at(p, wp, k, b), value(pair, ab));
                        set(at(p, wp, j, b), at(p, wp, k, a), value(pair, ab));
                        ab += 1;
                    }
                }
            }
        }
    }
}

/// The pair (j, k), j ≤ k, at place `pair` of the upper triangle over `n` units.
fn unpair(mut pair: usize, n: usize) -> (usize, usize) {
    let mut j = 0;
    while pair >= n - j {
        pair -= n - j;
        j += 1;
    }
    (j, j + pair)
}

impl Block {
    fn new(p: usize, q: usize, units: usize, inputs: usize) -> Block {
        let padded = |m: usize, n: usize| (m.next_multiple_of(PAD_A), n.next_multiple_of(PAD_B));
        let (straight, crosswise) = (padded(units, inputs), padded(inputs, units));
        // Whichever has less padding to multiply.
        let swapped = crosswise.0 * crosswise.1 < straight.0 * straight.1;
        let (lda, ldb) = if swapped { crosswise } else { straight };
        Block {
            p,
            q,
            units,
            inputs,
            swapped,
            lda,
            ldb,
            sums: vec![0.0; lda * ldb],
        }
    }
}
