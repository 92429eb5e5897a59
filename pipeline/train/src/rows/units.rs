//! The units of a net: scales of inputs and outputs.

use crate::net::tile::CHANNELS;

/// An input and its scale.
#[derive(Clone, Debug, PartialEq)]
pub struct Input {
    /// Place in `rrf_field::inputs::INPUTS`.
    pub id: u8,
    /// Mean over the training rows.
    pub offset: f32,
    /// 1 / standard deviation over the training rows.
    pub scale: f32,
}

/// Scale and offset of the output channels, in units of radiance (or radiance over base).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutputScale {
    /// Multiplied onto net outputs.
    pub scale: [f32; CHANNELS],
    /// Added after that.
    pub offset: [f32; CHANNELS],
    /// Whether the target is the same in all rows.
    pub constant: bool,
}

/// What raw rows become a net's rows by.
#[derive(Clone, Debug)]
pub struct Units {
    /// Inputs and their scales.
    pub inputs: Vec<Input>,
    /// Scale of the targets.
    pub output: OutputScale,
    /// Targets are divided by the base colour.
    pub divide_base: bool,
}
