//! Rows as raw columns, in the order of [`crate::inputs`].

use crate::inputs::registry::{Place, RAW, RAW_NAMES};

/// How many raw columns a row has.
pub const COUNT: usize = RAW;
/// Names of the raw columns, in order.
pub const NAMES: [&str; COUNT] = RAW_NAMES;
/// First column of the surface point.
pub const P: usize = Place::px as usize;
/// First column of the normal.
pub const N: usize = Place::nx as usize;
/// First column of the viewer direction.
pub const V: usize = Place::vx as usize;
/// First column of the light position.
pub const L: usize = Place::lx as usize;
/// How many columns are geometry (the columns of a points table).
pub const GEOMETRY: usize = L + 3;
/// First column of the base colour.
pub const BASE: usize = Place::base_r as usize;
/// Column of the roughness.
pub const ROUGHNESS: usize = Place::roughness as usize;
/// Column of metallic.
pub const METALLIC: usize = Place::metallic as usize;
/// Column of the dielectric specular.
pub const SPECULAR: usize = Place::specular as usize;

/// Many rows as parallel columns, all of one length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Columns {
    /// `columns[c][row]`, c as in [`NAMES`].
    pub columns: [Vec<f32>; COUNT],
}

impl Columns {
    /// How many rows.
    pub fn len(&self) -> usize {
        self.columns[0].len()
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Three columns of one row, for example `vec3(P, row)`.
    pub fn vec3(&self, first: usize, row: usize) -> [f32; 3] {
        [
            self.columns[first][row],
            self.columns[first + 1][row],
            self.columns[first + 2][row],
        ]
    }

    /// Appends one row.
    pub fn push(&mut self, row: [f32; COUNT]) {
        for (column, value) in self.columns.iter_mut().zip(row) {
            column.push(value);
        }
    }

    /// One row.
    pub fn row(&self, row: usize) -> [f32; COUNT] {
        std::array::from_fn(|c| self.columns[c][row])
    }

    /// The rows named, in the order named.
    pub fn take(&self, rows: &[u32]) -> Columns {
        Columns {
            columns: std::array::from_fn(|c| {
                rows.iter().map(|&r| self.columns[c][r as usize]).collect()
            }),
        }
    }
}
