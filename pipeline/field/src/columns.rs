//! The raw columns of a row, in one fixed order.

/// Names of the raw columns, as in `schemas/samples.toml`; world frame, metres.
pub const NAMES: [&str; COUNT] = [
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
];
/// How many raw columns a row has.
pub const COUNT: usize = 18;
/// How many of them are geometry (the columns of a points table).
pub const GEOMETRY: usize = 12;
/// First column of the surface point.
pub const P: usize = 0;
/// First column of the normal.
pub const N: usize = 3;
/// First column of the viewer direction.
pub const V: usize = 6;
/// First column of the light position.
pub const L: usize = 9;
/// First column of the base colour.
pub const BASE: usize = 12;
/// Column of the roughness.
pub const ROUGHNESS: usize = 15;
/// Column of metallic.
pub const METALLIC: usize = 16;
/// Column of the dielectric specular.
pub const SPECULAR: usize = 17;

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
