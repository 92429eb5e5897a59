//! Products with the Jacobian of a net, J v forwards and Jᵀ u backwards, without ever forming it.
//!
//! Along w + t v a layer's sum z = W x has z' = V x + W x', and behind the tanh h' = (1 − h²) z'
//! (forward mode); backwards it is the pass of the gradient (Pearlmutter 1994, Schraudolph 2002).
//! Both cost about as many multiply-adds as two passes through the net, so JᵀWJ v costs a small
//! share of JᵀWJ.

use crate::net::simd::{TILE_ROWS, TileLane, fma};
use crate::net::tile::{CHANNELS, Tile, from_above};
use multiversion::multiversion;
use multiversion::target::target_cfg_f;

/// Partial sums of a scalar product: every eighth row.
type Eighths = [f64; 8];

/// What a tile leaves behind for products at the same weights.
#[derive(Clone)]
struct Kept {
    /// Inputs, then the hidden units of every layer.
    z: Vec<Vec<TileLane>>,
    s: [TileLane; CHANNELS],
}

/// A net linearised at some weights on all rows. What a tile leaves behind is held in memory, 8 bytes
/// a row for each input and unit, or, where rows are not, made again for each product.
#[derive(Default)]
pub(crate) struct Linearised {
    pub w: Vec<f64>,
    /// One alone where tiles are made again.
    tiles: Vec<Kept>,
    used: usize,
    holds: bool,
    /// Scalar products of each weight's two factors over the rows so far.
    sums: Vec<Eighths>,
    /// Derivatives of one layer's units: of the outputs' sums backwards, along v forwards.
    below: Vec<TileLane>,
    above: Vec<TileLane>,
}

impl Linearised {
    /// Forgets the tiles; from here on those at weights `w` are noted, and held or not.
    pub fn begin(&mut self, w: &[f64], holds: bool) {
        self.holds = holds;
        self.w.clear();
        self.w.extend_from_slice(w);
        self.used = 0;
        self.restart();
    }

    /// Notes a tile after its forward pass and residuals, and adds its share of JᵀW r for the
    /// weighted residuals r.
    pub fn note(&mut self, tile: &Tile, r: &[TileLane; CHANNELS]) {
        let at = self.keep(tile);
        let mut u = tile.s;
        times(&mut u, r);
        self.backward(tile, at, u);
    }

    /// Where a tile is kept.
    fn keep(&mut self, tile: &Tile) -> usize {
        let at = if self.holds { self.used } else { 0 };
        match self.tiles.get_mut(at) {
            Some(kept) => {
                kept.s = tile.s;
                for (l, z) in kept.z.iter_mut().enumerate() {
                    z.copy_from_slice(tile.input_of(l));
                }
            }
            None => {
                let mut z = vec![tile.batch.x.clone()];
                z.extend_from_slice(&tile.hidden);
                self.tiles.push(Kept { z, s: tile.s });
            }
        }
        self.used = at + 1;
        at
    }

    /// The sums over all tiles since [`Linearised::begin`] or [`Linearised::restart`].
    pub fn finish(&self, out: &mut [f64]) {
        for (out, sums) in out.iter_mut().zip(&self.sums) {
            *out = sums.iter().sum();
        }
    }

    /// JᵀWJ v of the tiles held; `tile` tells the net's shape.
    pub fn product(&mut self, tile: &Tile, v: &[f64], out: &mut [f64]) {
        self.restart();
        for at in 0..self.used {
            self.add_product(tile, at, v);
        }
        self.finish(out);
    }

    /// Adds the share that a tile, made again, has of a product.
    pub fn product_of(&mut self, tile: &Tile, v: &[f64]) {
        let at = self.keep(tile);
        self.add_product(tile, at, v);
    }

    fn add_product(&mut self, tile: &Tile, at: usize, v: &[f64]) {
        let mut u = self.forward(tile, at, v);
        let s = self.tiles[at].s;
        times(&mut u, &s);
        times(&mut u, &s);
        self.backward(tile, at, u);
    }

    /// Forgets the sums.
    pub fn restart(&mut self) {
        self.sums.clear();
        self.sums.resize(self.w.len(), [0.0; 8]);
    }

    /// Derivative along v of the last layer's sums.
    fn forward(&mut self, tile: &Tile, at: usize, v: &[f64]) -> [TileLane; CHANNELS] {
        self.below.clear();
        let mut out = [[0.0; TILE_ROWS]; CHANNELS];
        for (l, z) in self.tiles[at].z.iter().enumerate() {
            let (w, v) = (tile.layer(l, &self.w), tile.layer(l, v));
            if l == tile.depth() {
                tangents(w, v, z, &self.below, &mut out);
                break;
            }
            self.above.resize(tile.sizes[l + 1], [0.0; TILE_ROWS]);
            tangents(w, v, z, &self.below, &mut self.above);
            through_tanh(&self.tiles[at].z[l + 1], &mut self.above);
            std::mem::swap(&mut self.below, &mut self.above);
        }
        out
    }

    /// Adds Jᵀu, `u` by the last layer's sums.
    fn backward(&mut self, tile: &Tile, at: usize, u: [TileLane; CHANNELS]) {
        self.above.clear();
        self.above.extend_from_slice(&u);
        for (l, z) in self.tiles[at].z.iter().enumerate().rev() {
            let first = tile.offsets[l];
            let weights = self.above.len() * (z.len() + 1);
            add_products(&self.above, z, &mut self.sums[first..][..weights]);
            if l > 0 {
                self.below.resize(z.len(), [0.0; TILE_ROWS]);
                from_above(tile.layer(l, &self.w), &self.above, z, &mut self.below);
                std::mem::swap(&mut self.below, &mut self.above);
            }
        }
    }
}

pub(crate) fn times(u: &mut [TileLane; CHANNELS], s: &[TileLane; CHANNELS]) {
    for (u, s) in u.as_flattened_mut().iter_mut().zip(s.as_flattened()) {
        *u *= s;
    }
}

/// z'_j = v_j0 + Σ_k v_jk x_k + w_jk x'_k; no `slopes` where x does not depend on the weights.
#[multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512vl+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
fn tangents(w: &[f64], v: &[f64], x: &[TileLane], slopes: &[TileLane], out: &mut [TileLane]) {
    if target_cfg_f!(any(target_feature = "fma", target_arch = "aarch64")) {
        tangent_rows::<true>(w, v, x, slopes, out);
    } else {
        tangent_rows::<false>(w, v, x, slopes, out);
    }
}

/// Rows whose sums stay in registers.
const STRIP: usize = 32;

#[inline(always)]
fn tangent_rows<const FMA: bool>(
    w: &[f64],
    v: &[f64],
    x: &[TileLane],
    slopes: &[TileLane],
    out: &mut [TileLane],
) {
    let stride = x.len() + 1;
    let rows = w.chunks_exact(stride).zip(v.chunks_exact(stride));
    for (out, (w, v)) in out.iter_mut().zip(rows) {
        for (first, strip) in out.chunks_exact_mut(STRIP).enumerate() {
            let mut sum = [v[0]; STRIP];
            for (lanes, factors) in [(x, v), (slopes, w)] {
                for (x, factor) in lanes.iter().zip(&factors[1..]) {
                    for (s, x) in sum.iter_mut().zip(&x[first * STRIP..][..STRIP]) {
                        *s = fma::<FMA>(*factor, *x, *s);
                    }
                }
            }
            strip.copy_from_slice(&sum);
        }
    }
}

#[multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512vl+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
fn through_tanh(hidden: &[TileLane], units: &mut [TileLane]) {
    for (h, unit) in hidden.iter().zip(units) {
        for (unit, h) in unit.iter_mut().zip(h) {
            *unit *= 1.0 - h * h;
        }
    }
}

/// Adds Σ_rows u_j z_a to the sums `[units, inputs + 1]`, z_0 = 1.
#[multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512vl+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
fn add_products(u: &[TileLane], z: &[TileLane], sums: &mut [Eighths]) {
    if target_cfg_f!(any(target_feature = "fma", target_arch = "aarch64")) {
        add_product_rows::<true>(u, z, sums);
    } else {
        add_product_rows::<false>(u, z, sums);
    }
}

#[inline(always)]
fn add_product_rows<const FMA: bool>(u: &[TileLane], z: &[TileLane], sums: &mut [Eighths]) {
    for (u, sums) in u.iter().zip(sums.chunks_exact_mut(z.len() + 1)) {
        for u in u.as_chunks::<8>().0 {
            for (sum, u) in sums[0].iter_mut().zip(u) {
                *sum += u;
            }
        }
        let (quads, last) = z.as_chunks::<4>();
        let (to, to_last) = sums[1..].as_chunks_mut::<4>();
        for (z, sums) in quads.iter().zip(to) {
            products::<4, FMA>(u, z, sums);
        }
        for (z, sum) in last.iter().zip(to_last) {
            products::<1, FMA>(u, std::array::from_ref(z), std::array::from_mut(sum));
        }
    }
}

/// Several at a time: each sum waits for its last addition.
#[inline(always)]
fn products<const N: usize, const FMA: bool>(
    u: &TileLane,
    z: &[TileLane; N],
    sums: &mut [Eighths; N],
) {
    let mut here = *sums;
    for (k, u) in u.as_chunks::<8>().0.iter().enumerate() {
        for (sum, z) in here.iter_mut().zip(z) {
            for ((sum, u), z) in sum.iter_mut().zip(u).zip(&z.as_chunks::<8>().0[k]) {
                *sum = fma::<FMA>(*u, *z, *sum);
            }
        }
    }
    *sums = here;
}
