//! The nets over a block of rows: column by column, several neurons at a time.
//!
//! Every function here is inlined into one that is compiled for the processor it runs on
//! ([`crate::evaluate`]); `FUSED` and `LANES` are its fused multiply-add and its register shape.
//! A row's result depends on its own inputs only, never on its place in the block.

use super::exp::exp;
use super::packed::{Packed, group};
use super::tanh::{multiply_add, rational_tanh};
use crate::columns;
use crate::inputs::block::Block;
use crate::inputs::lane::Lane;
use std::ops::Range;

/// Working columns of one evaluation.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    /// Scaled inputs.
    pub scaled: Vec<Lane>,
    /// First-layer sums over the inputs that the light does not change.
    pub sums: Vec<Lane>,
    /// Activations, read and written in turn.
    pub activations: [Vec<Lane>; 2],
}

impl Scratch {
    /// Makes room for nets at most `width` units wide.
    pub fn widen(&mut self, width: usize) {
        let [x, y] = &mut self.activations;
        for lanes in [&mut self.scaled, &mut self.sums, x, y] {
            if lanes.len() < width {
                lanes.resize(width, Lane::ZERO);
            }
        }
    }
}

/// Where the first layer's sums begin.
#[derive(Clone, Copy)]
pub enum Begin<'a> {
    /// At the model's own biases.
    Own,
    /// At these, one a unit.
    At(&'a [f32]),
    /// At these plus what `scratch.sums` holds.
    AfterSums(&'a [f32]),
}

/// Scales inputs `range` of the block's first `rows` rows into `scaled`.
#[inline(always)]
pub fn scale(
    packed: &Packed,
    range: Range<usize>,
    rows: usize,
    block: &Block,
    scaled: &mut [Lane],
) {
    for k in range {
        let source = &block[usize::from(packed.inputs[k])];
        let (offset, factor) = (packed.offset[k], packed.scale[k]);
        let target = scaled[k].0.as_chunks_mut::<16>().0;
        let source = source.0.as_chunks::<16>().0;
        for (out, x) in target.iter_mut().zip(source).take(rows.div_ceil(16)) {
            for i in 0..16 {
                out[i] = (x[i] - offset) * factor;
            }
        }
    }
}

/// First-layer sums over the inputs that the light does not change, without biases, into
/// `scratch.sums`, of the block's first `rows` rows.
#[inline(always)]
pub fn fixed_sums<const FUSED: bool, const LANES: usize, const HALF: usize>(
    packed: &Packed,
    rows: usize,
    scratch: &mut Scratch,
) {
    let (n_in, n_out) = (packed.sizes[0], packed.sizes[1]);
    let x = &scratch.scaled[..packed.fixed];
    let y = &mut scratch.sums[..n_out];
    y.iter_mut().for_each(|sum| sum.0.fill(0.0));
    let layer = Layer {
        weights: &packed.weights,
        inputs: n_in,
        skip: 0,
        begin: None,
        onto: true,
        hidden: false,
    };
    layer.sums::<FUSED, LANES, HALF>(rows, x, y);
}

/// The net on the scaled inputs `span` of the first `rows` rows, its output scaled back, into
/// `out`. Inputs outside the span are the business of `begin`.
#[inline(always)]
pub fn net<const FUSED: bool, const LANES: usize, const HALF: usize>(
    packed: &Packed,
    rows: usize,
    span: Range<usize>,
    begin: Begin,
    block: &Block,
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
        let mut layer = Layer {
            weights,
            inputs: n_in,
            skip: 0,
            begin: None,
            onto: false,
            hidden,
        };
        if l > 0 {
            layer.sums::<FUSED, LANES, HALF>(rows, &x[..n_in], target);
        } else {
            layer.skip = span.start;
            match begin {
                Begin::Own => {}
                Begin::At(biases) => layer.begin = Some(biases),
                Begin::AfterSums(biases) => {
                    layer.begin = Some(biases);
                    layer.onto = true;
                    target.copy_from_slice(&scratch.sums[..n_out]);
                }
            }
            layer.sums::<FUSED, LANES, HALF>(rows, &scratch.scaled[span.clone()], target);
        }
        weights = &weights[(n_in + 1) * n_out..];
        std::mem::swap(&mut x, &mut y);
    }
    finish::<FUSED>(packed, rows, block, out);
}

/// Exponentials where the outputs are exponents, output offset and scale, and the base colour
/// where the target was divided by it.
#[inline(always)]
fn finish<const FUSED: bool>(packed: &Packed, rows: usize, block: &Block, out: &mut [Lane; 3]) {
    for (c, out) in out.iter_mut().enumerate() {
        let (factor, offset) = (packed.output_scale[c], packed.output_offset[c]);
        let base = block[columns::BASE + c].0.as_chunks::<16>().0;
        let out = out.0.as_chunks_mut::<16>().0;
        for (y, base) in out.iter_mut().zip(base).take(rows.div_ceil(16)) {
            if packed.exponential {
                for y in y.iter_mut() {
                    *y = exp::<FUSED>(*y);
                }
            }
            for y in y.iter_mut() {
                *y = *y * factor + offset;
            }
            if packed.divide_base {
                for i in 0..16 {
                    y[i] *= base[i];
                }
            }
        }
    }
}

/// One layer, or the part of it over some of its inputs.
struct Layer<'a> {
    /// As in [`Packed::weights`], from this layer on.
    weights: &'a [f32],
    /// Inputs of the whole layer.
    inputs: usize,
    /// Inputs before those that are summed.
    skip: usize,
    /// Biases in place of the layer's own, one a unit.
    begin: Option<&'a [f32]>,
    /// The sums go on from what the units hold; without `begin`, no bias is added to that.
    onto: bool,
    /// tanh of the sums.
    hidden: bool,
}

impl Layer<'_> {
    /// The sums over the inputs `x`, of the first `rows` rows.
    #[inline(always)]
    fn sums<const FUSED: bool, const LANES: usize, const HALF: usize>(
        &self,
        rows: usize,
        x: &[Lane],
        y: &mut [Lane],
    ) {
        let (mut w, mut y, mut unit) = (self.weights, y, 0);
        while !y.is_empty() {
            let size = group(y.len());
            let (now, later) = y.split_at_mut(size);
            match size {
                1 => self.some::<FUSED, LANES, HALF, 1>(w, unit, rows, x, now),
                2 => self.some::<FUSED, LANES, HALF, 2>(w, unit, rows, x, now),
                _ => self.some::<FUSED, LANES, HALF, 4>(w, unit, rows, x, now),
            }
            w = &w[size * (self.inputs + 1)..];
            y = later;
            unit += size;
        }
    }

    /// `J` units, the first of them `unit`, whose weights are `w`.
    #[inline(always)]
    fn some<const FUSED: bool, const LANES: usize, const HALF: usize, const J: usize>(
        &self,
        w: &[f32],
        unit: usize,
        rows: usize,
        x: &[Lane],
        y: &mut [Lane],
    ) {
        let Some(y) = y.first_chunk_mut::<J>() else {
            return;
        };
        let biases = match self.begin {
            Some(biases) => biases[unit..].first_chunk::<J>(),
            None if self.onto => Some(&[0.0; J]),
            None => w.first_chunk::<J>(),
        };
        let Some(biases) = biases else {
            return;
        };
        let w = w[J * (1 + self.skip)..].as_chunks::<J>().0;
        let (full, rest) = (rows / LANES, rows % LANES);
        let full = full + usize::from(rest > HALF);
        for r in 0..full {
            units::<FUSED, LANES, J>(w, *biases, self.onto, self.hidden, r, x, y);
        }
        if (1..=HALF).contains(&rest) {
            let r = full * (LANES / HALF);
            units::<FUSED, HALF, J>(w, *biases, self.onto, self.hidden, r, x, y);
        }
    }
}

/// `J` units side by side, rows `LANES` · `r` and following: J × LANES sums stay in registers.
#[inline(always)]
fn units<const FUSED: bool, const LANES: usize, const J: usize>(
    w: &[[f32; J]],
    biases: [f32; J],
    onto: bool,
    hidden: bool,
    r: usize,
    x: &[Lane],
    y: &mut [Lane; J],
) {
    let mut sums = [[0.0f32; LANES]; J];
    for j in 0..J {
        sums[j] = [biases[j]; LANES];
        if onto {
            sums[j] = add(y[j].0.as_chunks().0[r], sums[j]);
        }
    }
    for (x, w) in x.iter().zip(w) {
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
fn add<const LANES: usize>(mut a: [f32; LANES], b: [f32; LANES]) -> [f32; LANES] {
    for i in 0..LANES {
        a[i] += b[i];
    }
    a
}

#[inline(always)]
fn activate<const FUSED: bool, const LANES: usize>(mut z: [f32; LANES]) -> [f32; LANES] {
    for z in &mut z {
        *z = rational_tanh::<FUSED>(*z);
    }
    z
}
