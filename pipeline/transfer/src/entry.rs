//! What a row of the transfer holds.

use glam::Vec3;

/// What a column holds of a row, a channel [1/sr].
///
/// Materials are affine in the base colour of the row's own point: the radiance of the row
/// is `constant + base_color * base`, times the irradiance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Entry {
    /// What a base colour of 1 adds: the diffuse lobe, a metal's reflection.
    pub base: Vec3,
    /// What a base colour of 0 leaves: a dielectric's reflection.
    pub constant: Vec3,
}

impl Entry {
    /// The whole for a surface of this base colour.
    #[inline]
    pub fn coloured(&self, base_color: Vec3) -> Vec3 {
        self.constant + base_color * self.base
    }
}

/// One half of a row.
#[derive(Clone, Debug, Default)]
pub(crate) struct HalfRow {
    pub(crate) columns: Vec<u32>,
    pub(crate) entries: Vec<Entry>,
    /// Mean of 1 / distance of the first rays.
    pub(crate) nearness: f32,
}
