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

use crate::gemm::{self, PAD_A, PAD_B};
use crate::products::{self, Packed, STEP};
use crate::simd::TILE;
use crate::tile::{CHANNELS, Tile};

/// Gauss-Newton normal equations: matrix JᵀWJ (symmetric, full, row-major) and vector JᵀWr.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Normal {
    /// How many parameters.
    pub n: usize,
    /// `n * n` entries.
    pub matrix: Vec<f64>,
    /// `n` entries.
    pub gradient: Vec<f64>,
}

impl Normal {
    /// Zeros for `n` parameters.
    pub fn zeros(n: usize) -> Normal {
        Normal {
            n,
            matrix: vec![0.0; n * n],
            gradient: vec![0.0; n],
        }
    }
}

/// Products of one pair of layers over the rows: C = Aᵀ B.
struct Block {
    kind: Kind,
    /// Columns of A and B in use.
    m: usize,
    n: usize,
    lda: usize,
    ldb: usize,
    sums: Vec<f64>,
}

#[derive(Clone, Copy)]
enum Kind {
    /// Layers p > q, or p = q hidden; p may be the output layer.
    Pair { p: usize, q: usize },
    /// JᵀWr of layer l.
    Gradient { l: usize },
}

/// Sums the normal equations tile by tile.
pub struct Accumulator {
    /// Lowest weight layer whose weights are parameters; those below are held.
    first: usize,
    sizes: Vec<usize>,
    offsets: Vec<usize>,
    blocks: Vec<Block>,
    /// Row-major copies `[row][1, z_1, ...]` of the inputs of each layer.
    z: Vec<Packed>,
    /// Row-major copies of the gradients, one a layer and channel.
    g: Vec<Vec<Packed>>,
    /// Σ_c r_c g_c of each layer.
    u: Vec<Packed>,
    a: Vec<f64>,
    b: Vec<f64>,
}

fn triangle(n: usize) -> usize {
    n * (n + 1) / 2
}

impl Accumulator {
    /// Zero sums for all weights of nets of the tile's shape.
    pub fn new(tile: &Tile) -> Accumulator {
        Accumulator::above(tile, 0, true)
    }

    /// Zero sums for JᵀWr alone.
    pub fn gradient(tile: &Tile) -> Accumulator {
        Accumulator::above(tile, 0, false)
    }

    /// Zero sums for the weights of the output layer alone.
    pub fn output_layer(tile: &Tile) -> Accumulator {
        Accumulator::above(tile, tile.depth(), true)
    }

    fn above(tile: &Tile, first: usize, matrix: bool) -> Accumulator {
        let (sizes, top) = (tile.sizes.clone(), tile.depth());
        let ext = |l: usize| sizes[l] + 1;
        let mut blocks = Vec::new();
        for p in first..=top {
            for q in (first..=p).filter(|_| matrix) {
                let (m, n) = match (p == top, q == top, p == q) {
                    (true, true, _) => (CHANNELS, triangle(ext(p))),
                    (true, false, _) => (CHANNELS * sizes[q + 1], ext(p) * ext(q)),
                    (false, _, true) => (triangle(sizes[p + 1]), triangle(ext(p))),
                    (false, _, false) => (sizes[p + 1] * sizes[q + 1], ext(p) * ext(q)),
                };
                blocks.push(Block::new(Kind::Pair { p, q }, m, n));
            }
            blocks.push(Block::new(Kind::Gradient { l: p }, sizes[p + 1], ext(p)));
        }
        let widest = |f: fn(&Block) -> usize| blocks.iter().map(f).max().unwrap_or(0);
        let (a, b) = (widest(|b| b.lda), widest(|b| b.ldb));
        Accumulator {
            z: (0..=top).map(|l| Packed::new(ext(l))).collect(),
            g: (0..top)
                .map(|l| (0..CHANNELS).map(|_| Packed::new(sizes[l + 1])).collect())
                .collect(),
            u: (0..=top).map(|l| Packed::new(sizes[l + 1])).collect(),
            a: vec![0.0; a * TILE + STEP],
            b: vec![0.0; b * TILE + STEP],
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
        for block in &mut self.blocks {
            block.sums.fill(0.0);
        }
    }

    /// Adds the rows of a tile after its forward, residual and backward passes.
    pub fn add(&mut self, tile: &Tile) {
        self.pack(tile);
        let rows = tile.batch.rows;
        for at in 0..self.blocks.len() {
            let Block { kind, lda, ldb, .. } = self.blocks[at];
            match kind {
                Kind::Pair { p, q } => self.pair(tile, p, q, lda, ldb),
                Kind::Gradient { l } => {
                    products::copy(&self.u[l], rows, lda, &mut self.a);
                    products::copy(&self.z[l], rows, ldb, &mut self.b);
                }
            }
            let sums = &mut self.blocks[at].sums;
            gemm::accumulate(&self.a[..rows * lda], lda, &self.b[..rows * ldb], ldb, sums);
        }
    }

    /// Row-major copies of what the products read.
    fn pack(&mut self, tile: &Tile) {
        for (l, z) in self.z.iter_mut().enumerate().skip(self.first) {
            z.set(0, &[1.0; TILE]);
            for (j, lane) in tile.input_of(l).iter().enumerate() {
                z.set(j + 1, lane);
            }
        }
        for (l, g) in self.g.iter_mut().enumerate().skip(self.first) {
            let n = self.sizes[l + 1];
            for j in 0..n {
                let mut u = [0.0; TILE];
                for (c, (packed, r)) in g.iter_mut().zip(&tile.r).enumerate() {
                    let lane = &tile.g[l][c * n + j];
                    packed.set(j, lane);
                    for i in 0..TILE {
                        u[i] += r[i] * lane[i];
                    }
                }
                self.u[l].set(j, &u);
            }
        }
        if let Some(top) = self.u.last_mut() {
            for c in 0..CHANNELS {
                let lane = std::array::from_fn(|i| tile.r[c][i] * tile.s[c][i]);
                top.set(c, &lane);
            }
        }
    }

    /// Fills A and B for one pair of layers.
    fn pair(&mut self, tile: &Tile, p: usize, q: usize, lda: usize, ldb: usize) {
        let (top, rows) = (tile.depth(), tile.batch.rows);
        let (a, b, n) = (&mut self.a, &mut self.b, &self.sizes);
        if p == q {
            products::upper(&self.z[p], n[p] + 1, rows, ldb, b);
        } else {
            products::outer(&self.z[p], n[p] + 1, &self.z[q], n[q] + 1, rows, ldb, b);
        }
        if q == top {
            for (row, a) in a.chunks_exact_mut(lda).take(rows).enumerate() {
                for (a, s) in a.iter_mut().zip(&tile.s) {
                    *a = s[row] * s[row];
                }
            }
        } else if p == top {
            for (row, a) in a.chunks_exact_mut(lda).take(rows).enumerate() {
                for c in 0..CHANNELS {
                    let g = &self.g[q][c].row(row)[..n[q + 1]];
                    for (a, g) in a[c * n[q + 1]..].iter_mut().zip(g) {
                        *a = tile.s[c][row] * g;
                    }
                }
            }
        } else {
            let triangular = p == q;
            products::over_channels(
                (&self.g[p], n[p + 1]),
                (&self.g[q], n[q + 1]),
                triangular,
                rows,
                lda,
                a,
            );
        }
    }

    /// The sums as JᵀWr.
    pub fn finish_gradient(&self, gradient: &mut [f64]) {
        for block in &self.blocks {
            let Kind::Gradient { l } = block.kind else {
                continue;
            };
            let width = self.sizes[l] + 1;
            for (unit, sums) in block.sums.chunks_exact(block.ldb).take(block.m).enumerate() {
                gradient[self.offsets[l] + unit * width..][..width].copy_from_slice(&sums[..width]);
            }
        }
    }

    /// The sums as full normal equations.
    pub fn finish(&self, normal: &mut Normal) {
        let n = normal.n;
        self.finish_gradient(&mut normal.gradient);
        for block in &self.blocks {
            if let Kind::Pair { p, q } = block.kind {
                self.spread(block, p, q, normal);
            }
        }
        for i in 0..n {
            for j in 0..i {
                normal.matrix[j * n + i] = normal.matrix[i * n + j];
            }
        }
    }

    /// Writes one block where row ≥ column.
    fn spread(&self, block: &Block, p: usize, q: usize, normal: &mut Normal) {
        let top = self.sizes.len() - 2;
        let (wp, wq) = (self.sizes[p] + 1, self.sizes[q] + 1);
        let n = normal.n;
        let at = |l: usize, width: usize, unit: usize, a: usize| self.offsets[l] + unit * width + a;
        let mut set = |row: usize, column: usize, value: f64| {
            let (row, column) = (row.max(column), row.min(column));
            normal.matrix[row * n + column] = value;
        };
        for (pair, sums) in block.sums.chunks_exact(block.ldb).take(block.m).enumerate() {
            let sums = &sums[..block.n];
            if p != q {
                let (j, k) = (pair / self.sizes[q + 1], pair % self.sizes[q + 1]);
                for (ab, value) in sums.iter().enumerate() {
                    set(at(p, wp, j, ab / wq), at(q, wq, k, ab % wq), *value);
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
                        set(at(p, wp, j, a), at(p, wp, k, b), sums[ab]);
                        set(at(p, wp, j, b), at(p, wp, k, a), sums[ab]);
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
    fn new(kind: Kind, m: usize, n: usize) -> Block {
        let (lda, ldb) = (m.next_multiple_of(PAD_A), n.next_multiple_of(PAD_B));
        Block {
            kind,
            m,
            n,
            lda,
            ldb,
            sums: vec![0.0; lda * ldb],
        }
    }
}
