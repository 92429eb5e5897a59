//! Second derivatives of a net's outputs along a direction in weight space, for geodesic
//! acceleration.
//!
//! Along w + t v a layer's sum z = W x has z' = V x + W x' and z'' = 2 V x' + W x''; behind the
//! tanh, h' = (1 − h²) z' and h'' = (1 − h²) (z'' − 2 h z'²).

use crate::net::simd::{TILE_ROWS, TileLane};
use crate::net::tile::{CHANNELS, Tile};
use multiversion::multiversion;

/// First and second derivatives of one layer's units.
#[derive(Clone, Default)]
struct Derivatives {
    first: Vec<TileLane>,
    second: Vec<TileLane>,
}

/// d²out/dt² at t = 0 along w + t v, after the tile's forward pass with weights `w`. For outputs
/// exp(z) it is divided by ∂out/∂z, which the tile's residual weights hold: z'' + z'².
pub(crate) fn second_derivative(tile: &Tile, w: &[f64], v: &[f64]) -> [TileLane; CHANNELS] {
    let none = vec![[0.0; TILE_ROWS]; tile.sizes[0]];
    let mut below = Derivatives {
        first: none.clone(),
        second: none,
    };
    let mut above = Derivatives::default();
    for l in 0..=tile.depth() {
        let (w, v) = (tile.layer(l, w), tile.layer(l, v));
        let units = tile.sizes[l + 1];
        above.first.resize(units, [0.0; TILE_ROWS]);
        above.second.resize(units, [0.0; TILE_ROWS]);
        sums(w, v, tile.input_of(l), &below, &mut above);
        if let Some(hidden) = tile.hidden.get(l) {
            through_tanh(hidden, &mut above);
        }
        std::mem::swap(&mut below, &mut above);
    }
    let mut out = [[0.0; TILE_ROWS]; CHANNELS];
    for ((out, first), second) in out.iter_mut().zip(&below.first).zip(&below.second) {
        *out = *second;
        if tile.exponential {
            for (out, first) in out.iter_mut().zip(first) {
                *out += first * first;
            }
        }
    }
    out
}

#[multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512vl+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
fn sums(w: &[f64], v: &[f64], x: &[TileLane], below: &Derivatives, above: &mut Derivatives) {
    let stride = x.len() + 1;
    let rows = w.chunks_exact(stride).zip(v.chunks_exact(stride));
    let targets = above.first.iter_mut().zip(&mut above.second);
    for ((w, v), (first, second)) in rows.zip(targets) {
        *first = [v[0]; TILE_ROWS];
        *second = [0.0; TILE_ROWS];
        for (k, x) in x.iter().enumerate() {
            let (w, v) = (w[k + 1], v[k + 1]);
            let (d, dd) = (&below.first[k], &below.second[k]);
            for i in 0..TILE_ROWS {
                first[i] += v * x[i] + w * d[i];
                second[i] += 2.0 * v * d[i] + w * dd[i];
            }
        }
    }
}

#[multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512vl+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
fn through_tanh(hidden: &[TileLane], units: &mut Derivatives) {
    let targets = units.first.iter_mut().zip(&mut units.second);
    for (h, (first, second)) in hidden.iter().zip(targets) {
        for i in 0..TILE_ROWS {
            let slope = 1.0 - h[i] * h[i];
            second[i] = slope * (second[i] - 2.0 * h[i] * first[i] * first[i]);
            first[i] *= slope;
        }
    }
}
