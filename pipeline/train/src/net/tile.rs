//! A net over one tile of rows: forward pass, residuals and the gradients of the outputs.
//!
//! Weight layer l maps `z[l]` (layer 0: the inputs) to the next units; layers below the last
//! have a tanh. Everything here runs across the rows of the tile.

use crate::net::simd::{self, TILE_ROWS, TileLane, fma};
use multiversion::multiversion;
use multiversion::target::target_cfg_f;
use rrf_field::net::Shape;

/// Output channels of every net.
pub const CHANNELS: usize = 3;

/// Rows as a net is trained on them, in the net's own units.
#[derive(Clone)]
pub struct Batch {
    /// How many rows are in use; the others have gain 0.
    pub rows: usize,
    /// Scaled inputs, one lane an input.
    pub x: Vec<TileLane>,
    /// Targets in the net's units, one lane a channel.
    pub target: [TileLane; CHANNELS],
    /// Radiance a unit of net output; 0 takes the entry out of the fit.
    pub gain: [TileLane; CHANNELS],
    /// Mean over channels of the radiance that belongs to net output 0:
    /// mean = `base` + Σ_c gain_c out_c / 3.
    pub base: TileLane,
}

impl Batch {
    /// Room for a tile of rows with `inputs` inputs.
    pub fn new(inputs: usize) -> Batch {
        Batch {
            rows: 0,
            x: vec![[0.0; TILE_ROWS]; inputs],
            target: [[0.0; TILE_ROWS]; CHANNELS],
            gain: [[0.0; TILE_ROWS]; CHANNELS],
            base: [0.0; TILE_ROWS],
        }
    }

    /// Takes every row out, so that a shorter tile leaves nothing behind.
    pub fn clear(&mut self) {
        self.rows = 0;
        self.x.iter_mut().for_each(|lane| *lane = [0.0; TILE_ROWS]);
        self.gain = [[0.0; TILE_ROWS]; CHANNELS];
        self.target = [[0.0; TILE_ROWS]; CHANNELS];
        self.base = [0.0; TILE_ROWS];
    }
}

/// A source of rows, read tile by tile; it may hold them in memory or stream them.
pub trait Rows {
    /// How many rows there are.
    fn len(&self) -> usize;
    /// Whether there are none.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// Loads up to [`TILE_ROWS`] rows from row `first` on into a cleared batch.
    fn load(&self, first: usize, batch: &mut Batch);
    /// Whether they are few enough to be held in memory, with what a pass makes of each.
    fn held(&self) -> bool {
        true
    }
    /// Whether to give up: what is summed over them then has no meaning.
    fn halted(&self) -> bool {
        false
    }
}

impl<R: Rows> Rows for &R {
    fn len(&self) -> usize {
        (*self).len()
    }

    fn load(&self, first: usize, batch: &mut Batch) {
        (*self).load(first, batch);
    }

    fn held(&self) -> bool {
        (*self).held()
    }

    fn halted(&self) -> bool {
        (*self).halted()
    }
}

/// What one tile's passes leave behind.
pub struct Tile {
    pub(crate) sizes: Vec<usize>,
    pub(crate) offsets: Vec<usize>,
    /// The rows.
    pub batch: Batch,
    /// Hidden units after tanh: `hidden[l]` feeds weight layer l + 1.
    pub(crate) hidden: Vec<Vec<TileLane>>,
    /// Outputs.
    pub out: [TileLane; CHANNELS],
    /// Whether outputs are exponentials of the last layer's sums.
    pub(crate) exponential: bool,
    /// Square root of the weight of each residual, times ∂out / ∂(last layer's sum).
    pub(crate) s: [TileLane; CHANNELS],
    /// Weighted residuals s (out − target).
    pub(crate) r: [TileLane; CHANNELS],
    /// s_c ∂out_c / ∂(unit before tanh), at `[l][c * units + j]`.
    pub(crate) g: Vec<Vec<TileLane>>,
}

impl Tile {
    /// Room for one tile through a net of this shape.
    pub fn new(shape: &Shape) -> Tile {
        let sizes = shape.sizes.clone();
        let inner = sizes
            .get(1..sizes.len().saturating_sub(1))
            .unwrap_or_default();
        let room = |times: usize| -> Vec<Vec<TileLane>> {
            inner
                .iter()
                .map(|n| vec![[0.0; TILE_ROWS]; n * times])
                .collect()
        };
        Tile {
            batch: Batch::new(sizes.first().copied().unwrap_or(0)),
            hidden: room(1),
            g: room(CHANNELS),
            offsets: shape.offsets(),
            out: [[0.0; TILE_ROWS]; CHANNELS],
            exponential: false,
            s: [[0.0; TILE_ROWS]; CHANNELS],
            r: [[0.0; TILE_ROWS]; CHANNELS],
            sizes,
        }
    }

    /// Whether the outputs are exponentials of the last layer's sums from here on.
    pub fn set_exponential(&mut self, exponential: bool) {
        self.exponential = exponential;
    }

    /// How many hidden layers.
    pub(crate) fn depth(&self) -> usize {
        self.hidden.len()
    }

    /// The lanes that feed weight layer `l`.
    pub(crate) fn input_of(&self, l: usize) -> &[TileLane] {
        if l == 0 {
            &self.batch.x
        } else {
            &self.hidden[l - 1]
        }
    }

    /// The weights of layer `l`, `[units, inputs + 1]`.
    pub(crate) fn layer<'w>(&self, l: usize, weights: &'w [f64]) -> &'w [f64] {
        let length = (self.sizes[l] + 1) * self.sizes[l + 1];
        &weights[self.offsets[l]..][..length]
    }

    /// Hidden units and outputs of the batch.
    pub fn forward(&mut self, weights: &[f64]) {
        for l in 0..self.depth() {
            let w = self.layer(l, weights);
            let (below, above) = self.hidden.split_at_mut(l);
            let x = below.last().unwrap_or(&self.batch.x);
            dense(w, x, &mut above[0]);
            simd::tanh(above[0].as_flattened_mut());
        }
        let w = self.layer(self.depth(), weights);
        dense(
            w,
            self.hidden.last().unwrap_or(&self.batch.x),
            &mut self.out,
        );
        if self.exponential {
            simd::exponential(self.out.as_flattened_mut());
        }
    }

    /// Residuals weighted by gain times `divisor`, one value a row; returns Σ r².
    /// Leaves in `s` what the derivatives of the last layer's sums are weighted by.
    pub fn residuals(&mut self, divisor: &[f64]) -> f64 {
        let mut sum = 0.0;
        for c in 0..CHANNELS {
            self.s[c] = [0.0; TILE_ROWS];
            for (s, (k, d)) in self.s[c]
                .iter_mut()
                .zip(self.batch.gain[c].iter().zip(divisor))
            {
                *s = k * d;
            }
            for i in 0..TILE_ROWS {
                self.r[c][i] = self.s[c][i] * (self.out[c][i] - self.batch.target[c][i]);
            }
            sum += self.r[c].iter().map(|r| r * r).sum::<f64>();
            if self.exponential {
                // ∂ exp(z) / ∂z = exp(z)
                for (s, out) in self.s[c].iter_mut().zip(&self.out[c]) {
                    *s *= out;
                }
            }
        }
        sum
    }

    /// Mean of the channels of `share` times the targets plus 1 − `share` times the
    /// present outputs.
    pub fn channel_mean(&self, share: f64) -> TileLane {
        let Batch {
            gain, target, base, ..
        } = &self.batch;
        let mut sum = [0.0; TILE_ROWS];
        for c in 0..CHANNELS {
            for i in 0..TILE_ROWS {
                let value = share * target[c][i] + (1.0 - share) * self.out[c][i];
                sum[i] += gain[c][i] * value;
            }
        }
        std::array::from_fn(|i| base[i] + sum[i] / CHANNELS as f64)
    }

    /// Gradients of the weighted outputs with respect to every hidden unit's sum.
    pub(crate) fn backward(&mut self, weights: &[f64]) {
        let top = self.depth();
        for l in (0..top).rev() {
            let w = self.layer(l + 1, weights);
            let (below, above) = self.g.split_at_mut(l + 1);
            if l + 1 == top {
                for c in 0..CHANNELS {
                    let n = self.sizes[l + 1];
                    let row = &w[c * (n + 1)..][..n + 1];
                    let g = &mut below[l][c * n..][..n];
                    from_output(row, &self.s[c], &self.hidden[l], g);
                }
            } else {
                let (n, m) = (self.sizes[l + 1], self.sizes[l + 2]);
                for c in 0..CHANNELS {
                    let g = &mut below[l][c * n..][..n];
                    from_above(w, &above[0][c * m..][..m], &self.hidden[l], g);
                }
            }
        }
    }
}

/// out_j = w_j0 + Σ_l w_jl x_l.
#[multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512vl+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
fn dense(w: &[f64], x: &[TileLane], out: &mut [TileLane]) {
    if target_cfg_f!(any(target_feature = "fma", target_arch = "aarch64")) {
        dense_rows::<true>(w, x, out);
    } else {
        dense_rows::<false>(w, x, out);
    }
}

/// Rows whose sums stay in registers.
const STRIP: usize = 32;

#[inline(always)]
fn dense_rows<const FMA: bool>(w: &[f64], x: &[TileLane], out: &mut [TileLane]) {
    for (out, w) in out.iter_mut().zip(w.chunks_exact(x.len() + 1)) {
        for (first, strip) in out.chunks_exact_mut(STRIP).enumerate() {
            let mut sum = [w[0]; STRIP];
            for (x, w) in x.iter().zip(&w[1..]) {
                for (s, x) in sum.iter_mut().zip(&x[first * STRIP..][..STRIP]) {
                    *s = fma::<FMA>(*w, *x, *s);
                }
            }
            strip.copy_from_slice(&sum);
        }
    }
}

/// g_j = s w_j (1 − h_j²): the output layer is linear.
#[multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512vl+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
fn from_output(row: &[f64], s: &TileLane, hidden: &[TileLane], g: &mut [TileLane]) {
    for ((g, h), w) in g.iter_mut().zip(hidden).zip(&row[1..]) {
        for i in 0..TILE_ROWS {
            g[i] = s[i] * w * (1.0 - h[i] * h[i]);
        }
    }
}

/// g_k = (Σ_j above_j w_jk) (1 − h_k²).
#[multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512vl+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
pub(crate) fn from_above(w: &[f64], above: &[TileLane], hidden: &[TileLane], g: &mut [TileLane]) {
    if target_cfg_f!(any(target_feature = "fma", target_arch = "aarch64")) {
        from_above_rows::<true>(w, above, hidden, g);
    } else {
        from_above_rows::<false>(w, above, hidden, g);
    }
}

#[inline(always)]
fn from_above_rows<const FMA: bool>(
    w: &[f64],
    above: &[TileLane],
    hidden: &[TileLane],
    g: &mut [TileLane],
) {
    let stride = hidden.len() + 1;
    for (k, (g, h)) in g.iter_mut().zip(hidden).enumerate() {
        for (first, strip) in g.chunks_exact_mut(STRIP).enumerate() {
            let mut sum = [0.0; STRIP];
            for (a, row) in above.iter().zip(w.chunks_exact(stride)) {
                let w = row[k + 1];
                for (s, a) in sum.iter_mut().zip(&a[first * STRIP..][..STRIP]) {
                    *s = fma::<FMA>(w, *a, *s);
                }
            }
            for ((g, s), h) in strip.iter_mut().zip(&sum).zip(&h[first * STRIP..]) {
                *g = s * (1.0 - h * h);
            }
        }
    }
}
