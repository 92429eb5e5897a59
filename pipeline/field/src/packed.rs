//! A cell's model laid out for streaming: what the block kernel reads, in the order it reads it.

use crate::columns;
use crate::model::{self, CellModel};

/// How many neurons the kernel computes together when `left` of a layer are left: 4, 2 or 1.
/// (Groups of 3 are not turned into vector instructions by the compiler.)
#[inline(always)]
pub fn group(left: usize) -> usize {
    match left {
        0 | 1 => left,
        2 | 3 => 2,
        _ => 4,
    }
}

/// One cell's model, ready for evaluation.
#[derive(Clone, Debug)]
pub struct Packed {
    /// Places in [`model::INPUTS`], those that the light does not change first.
    pub inputs: Vec<u8>,
    /// Raw columns to read for them, ascending.
    pub columns: Vec<u8>,
    /// Whether any input is derived.
    pub derived: bool,
    /// How many inputs the light does not change.
    pub fixed: usize,
    /// Offset of each input, in the order of `inputs`.
    pub offset: Vec<f32>,
    /// Scale of each input.
    pub scale: Vec<f32>,
    /// Units a layer, the inputs first.
    pub sizes: Vec<usize>,
    /// Layer by layer, [`group`] by group of neurons: their biases, then for each input
    /// their weights of it side by side.
    pub weights: Vec<f32>,
    /// Multiplied onto each output channel.
    pub output_scale: [f32; 3],
    /// Added after that.
    pub output_offset: [f32; 3],
    /// The base colour is multiplied onto the result.
    pub divide_base: bool,
    /// The outputs are exponents.
    pub exponential: bool,
}

impl Packed {
    /// Lays out a model whose lengths agree.
    pub fn new(model: &CellModel) -> Packed {
        let mut order: Vec<usize> = (0..model.inputs.len()).collect();
        order.sort_by_key(|&k| model::depends_on_light(model.inputs[k]));
        let inputs: Vec<u8> = order.iter().map(|&k| model.inputs[k]).collect();
        let derived = inputs.iter().any(|&i| usize::from(i) >= columns::COUNT);
        Packed {
            columns: columns_read(model, derived),
            derived,
            fixed: inputs
                .iter()
                .filter(|&&i| !model::depends_on_light(i))
                .count(),
            offset: order.iter().map(|&k| model.input_offset[k]).collect(),
            scale: order.iter().map(|&k| model.input_scale[k]).collect(),
            weights: pack_weights(model, &order),
            sizes: model.shape.sizes.clone(),
            inputs,
            output_scale: model.output_scale,
            output_offset: model.output_offset,
            divide_base: model.divide_base,
            exponential: model.exponential,
        }
    }

    /// Widest layer.
    pub fn width(&self) -> usize {
        self.sizes.iter().copied().max().unwrap_or(0)
    }
}

/// The raw columns behind the inputs; derived ones read all of the geometry.
fn columns_read(model: &CellModel, derived: bool) -> Vec<u8> {
    (0..columns::COUNT as u8)
        .filter(|&c| {
            let c_size = usize::from(c);
            model.inputs.contains(&c)
                || (derived && c_size < columns::GEOMETRY)
                || (model.divide_base && (columns::BASE..columns::BASE + 3).contains(&c_size))
        })
        .collect()
}

/// The flat weights regrouped; `order[k]` is the model's place of the k-th packed input.
fn pack_weights(model: &CellModel, order: &[usize]) -> Vec<f32> {
    let mut packed = Vec::with_capacity(model.weights.len());
    for (layer, start) in model.shape.offsets().into_iter().enumerate() {
        let (n_in, n_out) = (model.shape.sizes[layer], model.shape.sizes[layer + 1]);
        let sources: Vec<usize> = match layer {
            0 => order.to_vec(),
            _ => (0..n_in).collect(),
        };
        let row = |j: usize| &model.weights[start + j * (n_in + 1)..][..n_in + 1];
        let mut first = 0;
        while first < n_out {
            let neurons = first..first + group(n_out - first);
            packed.extend(neurons.clone().map(|j| row(j)[0]));
            for source in &sources {
                packed.extend(neurons.clone().map(|j| row(j)[1 + source]));
            }
            first = neurons.end;
        }
    }
    packed
}
