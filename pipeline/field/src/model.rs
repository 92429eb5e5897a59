//! A cell's model: which inputs it reads, how they are scaled, its net, how the output is scaled.

use crate::columns::{self, Columns};
use crate::net::Shape;

/// What a net can read. The first [`columns::COUNT`] are the raw columns in their order;
/// the rest are computed from them.
///
/// Add an input: append a name here and its formula in [`fill`].
pub const INPUTS: [&str; 25] = [
    "px",
    "py",
    "pz",
    "nx",
    "ny",
    "nz",
    "vx",
    "vy",
    "vz",
    "lx",
    "ly",
    "lz",
    "base_r",
    "base_g",
    "base_b",
    "roughness",
    "metallic",
    "specular",
    // unit direction from p to the light
    "dx",
    "dy",
    "dz",
    // 1 / (distance to the light)
    "inv_distance",
    // unit mirror direction of v about n, dotted with the direction to the light
    "mirror_light",
    // cosine between n and the direction to the light
    "cos_light",
    // cosine between n and v
    "cos_view",
];

/// One cell's model. Φ(x) = output_offset + output_scale ∘ net((input − input_offset) · input_scale),
/// times the base colour where `divide_base` is set.
#[derive(Clone, Debug, PartialEq)]
pub struct CellModel {
    /// The cell.
    pub cell: u32,
    /// Which inputs, as places in [`INPUTS`].
    pub inputs: Vec<u8>,
    /// Subtracted from each input.
    pub input_offset: Vec<f32>,
    /// Multiplied after the subtraction.
    pub input_scale: Vec<f32>,
    /// Layers of the net, inputs first, 3 outputs last.
    pub shape: Shape,
    /// Flat weights, see [`Shape`].
    pub weights: Vec<f32>,
    /// Multiplied onto each output channel.
    pub output_scale: [f32; 3],
    /// Added after that.
    pub output_offset: [f32; 3],
    /// The target was divided by the base colour; the model multiplies it back.
    pub divide_base: bool,
}

/// Computes input `input` (a place in [`INPUTS`]) for all rows into `out`.
pub fn fill(input: u8, rows: &Columns, out: &mut Vec<f32>) {
    out.clear();
    if (input as usize) < columns::COUNT {
        out.extend_from_slice(&rows.columns[input as usize]);
        return;
    }
    let name = INPUTS[input as usize];
    out.extend((0..rows.len()).map(|r| derived(name, rows, r)));
}

fn derived(name: &str, rows: &Columns, r: usize) -> f32 {
    let (p, n, v, l) = (
        rows.vec3(columns::P, r),
        rows.vec3(columns::N, r),
        rows.vec3(columns::V, r),
        rows.vec3(columns::L, r),
    );
    let to = [l[0] - p[0], l[1] - p[1], l[2] - p[2]];
    let distance = dot(to, to).sqrt();
    let d = if distance > 0.0 {
        to.map(|x| x / distance)
    } else {
        [0.0; 3]
    };
    match name {
        "dx" => d[0],
        "dy" => d[1],
        "dz" => d[2],
        "inv_distance" => {
            if distance > 0.0 {
                1.0 / distance
            } else {
                0.0
            }
        }
        "mirror_light" => 2.0 * dot(n, v) * dot(n, d) - dot(v, d),
        "cos_light" => dot(n, d),
        "cos_view" => dot(n, v),
        _ => 0.0,
    }
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
