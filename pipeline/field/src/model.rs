//! A cell's model: which inputs it reads, how they are scaled, its net (or what stands in its place),
//! how the output is scaled.

use crate::columns::{self, Columns};
use crate::derived;
pub use crate::kind::{KINDS, Kind};
use crate::net::Shape;

/// What a net can read. The first [`columns::COUNT`] are the raw columns in their order;
/// the rest are computed from them.
///
/// Add an input: append a name here and its formula in [`derived::derive_block`].
pub const INPUTS: [&str; columns::COUNT + derived::DERIVED] = [
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
/// times the base colour where `divide_base` is set; for another [`Kind`] than a net its own function
/// stands in the net's place.
#[derive(Clone, Debug, PartialEq)]
pub struct CellModel {
    /// The cell.
    pub cell: u32,
    /// What its weights are of.
    pub kind: Kind,
    /// Which inputs, as places in [`INPUTS`].
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

/// Computes input `input` (a place in [`INPUTS`]) for all rows into `out`.
/// A place beyond the list gives zeros; [`crate::Field::new`] refuses such models.
pub fn fill(input: u8, rows: &Columns, out: &mut Vec<f32>) {
    let input = usize::from(input);
    out.clear();
    if let Some(column) = rows.columns.get(input) {
        out.extend_from_slice(column);
    } else if input < INPUTS.len() {
        derived::derive_column(input - columns::COUNT, rows, out);
    } else {
        out.resize(rows.len(), 0.0);
    }
}

/// Whether input `input` changes when only the light moves.
pub fn depends_on_light(input: u8) -> bool {
    const COS_VIEW: usize = columns::COUNT + 6;
    let input = usize::from(input);
    (columns::L..columns::L + 3).contains(&input) || (input >= columns::COUNT && input != COS_VIEW)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(light: f32) -> Columns {
        let mut rows = Columns::default();
        for r in 0..150 {
            let mut row = std::array::from_fn(|c| ((r * 31 + c * 17) as f32 * 0.37).sin());
            for l in &mut row[columns::L..columns::L + 3] {
                *l += light;
            }
            rows.push(row);
        }
        rows
    }

    #[test]
    fn light_dependence_is_as_declared() {
        let (here, there) = (rows(0.0), rows(1.0));
        let (mut a, mut b) = (Vec::new(), Vec::new());
        for input in 0..INPUTS.len() as u8 {
            fill(input, &here, &mut a);
            fill(input, &there, &mut b);
            assert_eq!(a.len(), here.len());
            assert_eq!(
                a != b,
                depends_on_light(input),
                "{}",
                INPUTS[input as usize]
            );
        }
    }

    #[test]
    fn filled_columns_equal_single_rows() {
        let rows = rows(0.3);
        let mut column = Vec::new();
        for k in 0..derived::DERIVED {
            fill((columns::COUNT + k) as u8, &rows, &mut column);
            for (r, got) in column.iter().enumerate() {
                let vec3 = |c| rows.vec3(c, r);
                let want = derived::derive(
                    vec3(columns::P),
                    vec3(columns::N),
                    vec3(columns::V),
                    vec3(columns::L),
                );
                assert_eq!(got.to_bits(), want[k].to_bits());
            }
        }
    }
}
