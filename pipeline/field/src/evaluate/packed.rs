//! A cell's model laid out for streaming: what the block kernel reads, in the order it reads it.

use crate::columns;
use crate::inputs::{self, Reads};
use crate::model::CellModel;

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
    /// Places in [`inputs::INPUTS`]: those that the light does not change, those that it changes
    /// from row to row, its own position.
    pub inputs: Vec<u8>,
    /// Raw columns to read for them, ascending.
    pub columns: Vec<u8>,
    /// Derived inputs to compute, in this order.
    pub derived: Vec<u8>,
    /// Those of them that the light changes.
    pub relit: Vec<u8>,
    /// How many inputs the light does not change.
    pub fixed: usize,
    /// How many inputs differ from row to row under one light.
    pub varying: usize,
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
        order.sort_by_key(|&k| dependence(model.inputs[k]));
        let inputs: Vec<u8> = order.iter().map(|&k| model.inputs[k]).collect();
        let upto = |last: Dependence| inputs.partition_point(|&i| dependence(i) <= last);
        let derived = inputs::derivation(&inputs);
        let of_light = |&input: &u8| inputs::depends_on_light(input);
        Packed {
            columns: columns_read(model),
            relit: derived.iter().copied().filter(of_light).collect(),
            derived,
            fixed: upto(Dependence::Fixed),
            varying: upto(Dependence::Varying),
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

    /// The first layer's biases for a light at `position`: what its own columns add is the same
    /// for every row. Summed in f64.
    pub fn biases(&self, position: [f32; 3], biases: &mut Vec<f32>) {
        let (n_in, n_out) = (self.sizes[0], self.sizes[1]);
        let mut weights = self.weights.as_slice();
        let mut left = n_out;
        while left > 0 {
            let size = group(left);
            let (now, later) = weights.split_at(size * (n_in + 1));
            for j in 0..size {
                let term = |k: usize| {
                    let l = position[usize::from(self.inputs[k]) - columns::L];
                    let x = (f64::from(l) - f64::from(self.offset[k])) * f64::from(self.scale[k]);
                    f64::from(now[(k + 1) * size + j]) * x
                };
                let sum: f64 = (self.varying..n_in).map(term).sum();
                biases.push((f64::from(now[j]) + sum) as f32);
            }
            (weights, left) = (later, left - size);
        }
    }

    /// Widest layer.
    pub fn width(&self) -> usize {
        self.sizes.iter().copied().max().unwrap_or(0)
    }
}

/// How an input depends on the light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Dependence {
    /// Not at all.
    Fixed,
    /// It changes with the light and from row to row.
    Varying,
    /// It is the light's position.
    Constant,
}

fn dependence(input: u8) -> Dependence {
    if (columns::L..columns::L + 3).contains(&usize::from(input)) {
        Dependence::Constant
    } else if inputs::depends_on_light(input) {
        Dependence::Varying
    } else {
        Dependence::Fixed
    }
}

/// The raw columns behind a model.
fn columns_read(model: &CellModel) -> Vec<u8> {
    let inputs = model.inputs.iter();
    let reads = inputs.fold(Reads::default(), |sum, &input| sum + inputs::reads(input));
    let base = |c: &usize| model.divide_base && (columns::BASE..columns::BASE + 3).contains(c);
    (0..columns::COUNT)
        .filter(|c| reads.contains(*c) || base(c))
        .map(|c| c as u8)
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
