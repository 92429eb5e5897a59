//! A cell's model: which inputs it reads, how they are scaled, its net (or what stands in its place),
//! how the output is scaled.

mod check;
mod kind;
pub mod net;

pub use kind::{Kind, MODEL_KINDS};
use net::Shape;

/// One cell's model. Φ(x) = output_offset + output_scale ∘ net((input − input_offset) · input_scale),
/// times the base colour where `divide_base` is set; for another [`Kind`] than a net its own function
/// stands in the net's place.
#[derive(Clone, Debug, PartialEq)]
pub struct CellModel {
    /// The cell.
    pub cell: u32,
    /// What its weights are of.
    pub kind: Kind,
    /// Which inputs, as places in [`crate::inputs::INPUTS`].
    pub inputs: Vec<u8>,
    /// Subtracted from each input.
    pub input_offset: Vec<f32>,
    /// Multiplied after the subtraction.
    pub input_scale: Vec<f32>,
    /// Layers of the net, inputs first, 3 outputs last; of another kind see [`Kind`].
    pub shape: Shape,
    /// Flat weights, see [`Shape`] and [`Kind`].
    pub weights: Vec<f32>,
    /// Multiplied onto each output channel.
    pub output_scale: [f32; 3],
    /// Added after that.
    pub output_offset: [f32; 3],
    /// The target was divided by the base colour; the model multiplies it back.
    pub divide_base: bool,
    /// The net's outputs are exponents: exp(min(net, MAX_EXPONENT)) in their place.
    pub exponential: bool,
}
