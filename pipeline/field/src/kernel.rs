//! The nets over a block of rows: column by column, several neurons at a time.
//!
//! Every function here is inlined into one that is compiled for the processor it runs on
//! ([`crate::evaluate`]); `FUSED` and `LANES` are its fused multiply-add and its register shape.
//! A row's result depends on its own inputs only, never on its place in the block.

use crate::columns;
use crate::derived::{BLOCK, DerivedBlock, Lane, RawBlock};
use crate::exp::exp;
use crate::packed::{Packed, group};
use crate::tanh::{multiply_add, tanh};

/// Working columns of one evaluation.
pub struct Scratch {
    /// Scaled inputs.
    pub scaled: Vec<Lane>,
    /// First-layer sums over the inputs that the light does not change.
    pub sums: Vec<Lane>,
    /// Activations, read and written in turn.
    pub activations: [Vec<Lane>; 2],
}

impl Scratch {
    /// For nets at most `width` units wide.
    pub fn new(width: usize) -> Scratch {
        let lanes = || vec![Lane::ZERO; width];
        Scratch {
            scaled: lanes(),
            sums: lanes(),
            activations: [lanes(), lanes()],
        }
    }
}

/// Scales inputs `range` of the block into `scaled`.
#[inline(always)]
pub fn scale(
    packed: &Packed,
    range: std::ops::Range<usize>,
    raw: &RawBlock,
    derived: &DerivedBlock,
    scaled: &mut [Lane],
) {
    for k in range {
        let input = usize::from(packed.inputs[k]);
        let source = match raw.get(input) {
            Some(lane) => lane,
            None => &derived[input - columns::COUNT],
        };
        let (offset, factor) = (packed.offset[k], packed.scale[k]);
        for (out, x) in scaled[k].0.iter_mut().zip(&source.0) {
            *out = (x - offset) * factor;
        }
    }
}

/// First-layer sums over the inputs that the light does not change, into `scratch.sums`,
/// of the block's first `rows` rows.
#[inline(always)]
pub fn fixed_sums<const FUSED: bool, const LANES: usize>(
    packed: &Packed,
    rows: usize,
    scratch: &mut Scratch,
) {
    let (n_in, n_out) = (packed.sizes[0], packed.sizes[1]);
    let x = &scratch.scaled[..packed.fixed];
    layer::<FUSED, LANES>(
        &packed.weights,
        rows,
        n_in,
        0,
        x,
        &mut scratch.sums[..n_out],
        false,
    );
}

/// The net on the scaled inputs of the first `rows` rows, its output scaled back, into `out`.
/// With `resume` the first layer goes on from `scratch.sums`; the bits are the same.
#[inline(always)]
pub fn net<const FUSED: bool, const LANES: usize>(
    packed: &Packed,
    rows: usize,
    resume: bool,
    raw: &RawBlock,
    scratch: &mut Scratch,
    out: &mut [Lane; 3],
) {
    let layers = packed.sizes.len() - 1;
    let [x, y] = &mut scratch.activations;
    let (mut x, mut y) = (x.as_mut_slice(), y.as_mut_slice());
    let mut weights = packed.weights.as_slice();
    for l in 0..layers {
        let (n_in, n_out) = (packed.sizes[l], packed.sizes[l + 1]);
        let hidden = l + 1 < layers;
        let target = if hidden {
            &mut y[..n_out]
        } else {
            &mut out[..]
        };
        if l > 0 {
            layer::<FUSED, LANES>(weights, rows, n_in, 0, &x[..n_in], target, hidden);
        } else if resume {
            target.copy_from_slice(&scratch.sums[..n_out]);
            let x = &scratch.scaled[packed.fixed..n_in];
            layer::<FUSED, LANES>(weights, rows, n_in, packed.fixed + 1, x, target, hidden);
        } else {
            let x = &scratch.scaled[..n_in];
            layer::<FUSED, LANES>(weights, rows, n_in, 0, x, target, hidden);
        }
        weights = &weights[(n_in + 1) * n_out..];
        std::mem::swap(&mut x, &mut y);
    }
    finish::<FUSED>(packed, raw, out);
}

/// Exponentials where the outputs are exponents, output offset and scale, and the base colour where the target was divided by it.
#[inline(always)]
fn finish<const FUSED: bool>(packed: &Packed, raw: &RawBlock, out: &mut [Lane; 3]) {
    for (c, out) in out.iter_mut().enumerate() {
        if packed.exponential {
            for y in &mut out.0 {
                *y = exp::<FUSED>(*y);
            }
        }
        let (factor, offset) = (packed.output_scale[c], packed.output_offset[c]);
        for y in &mut out.0 {
            *y = *y * factor + offset;
        }
        if packed.divide_base {
            for (y, base) in out.0.iter_mut().zip(&raw[columns::BASE + c].0) {
                *y *= base;
            }
        }
    }
}

/// Sums of one layer of `n_in` inputs over the inputs `x`, and tanh of them where `hidden`.
///
/// `skip` is 0 to start at the biases, or 1 + the number of inputs already summed in `y`.
#[inline(always)]
fn layer<const FUSED: bool, const LANES: usize>(
    weights: &[f32],
    rows: usize,
    n_in: usize,
    skip: usize,
    x: &[Lane],
    y: &mut [Lane],
    hidden: bool,
) {
    let (mut w, mut y) = (weights, y);
    while !y.is_empty() {
        let size = group(y.len());
        let (now, later) = y.split_at_mut(size);
        match size {
            1 => neurons::<FUSED, LANES, 1>(w, rows, skip, x, now, hidden),
            2 => neurons::<FUSED, LANES, 2>(w, rows, skip, x, now, hidden),
            _ => neurons::<FUSED, LANES, 4>(w, rows, skip, x, now, hidden),
        }
        w = &w[size * (n_in + 1)..];
        y = later;
    }
}

/// `J` neurons side by side, `LANES` rows at a time: J × LANES sums stay in registers.
#[inline(always)]
fn neurons<const FUSED: bool, const LANES: usize, const J: usize>(
    weights: &[f32],
    rows: usize,
    skip: usize,
    x: &[Lane],
    y: &mut [Lane],
    hidden: bool,
) {
    let Some(y) = y.first_chunk_mut::<J>() else {
        return;
    };
    let (bias, weights) = weights.split_at(J * skip.max(1));
    for r in 0..rows.min(BLOCK).div_ceil(LANES) {
        let mut sums = [[0.0f32; LANES]; J];
        for j in 0..J {
            sums[j] = if skip == 0 {
                [bias[j]; LANES]
            } else {
                y[j].0.as_chunks().0[r]
            };
        }
        for (x, w) in x.iter().zip(weights.as_chunks::<J>().0) {
            let x: [f32; LANES] = x.0.as_chunks().0[r];
            for j in 0..J {
                sums[j] = accumulate::<FUSED, LANES>(sums[j], w[j], x);
            }
        }
        for j in 0..J {
            y[j].0.as_chunks_mut().0[r] = if hidden {
                activate::<FUSED, LANES>(sums[j])
            } else {
                sums[j]
            };
        }
    }
}

// Whole registers by value and plain loops: this form is turned into vector instructions
// reliably, which references into columns and `array::from_fn` are not.

#[inline(always)]
fn accumulate<const FUSED: bool, const LANES: usize>(
    mut sum: [f32; LANES],
    weight: f32,
    x: [f32; LANES],
) -> [f32; LANES] {
    for i in 0..LANES {
        sum[i] = multiply_add::<FUSED>(weight, x[i], sum[i]);
    }
    sum
}

#[inline(always)]
fn activate<const FUSED: bool, const LANES: usize>(mut z: [f32; LANES]) -> [f32; LANES] {
    for z in &mut z {
        *z = tanh::<FUSED>(*z);
    }
    z
}
