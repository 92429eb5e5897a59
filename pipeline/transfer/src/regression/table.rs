//! Rows as regression sees them: where, and what an ensemble of lights makes of them.

use crate::query::TransferQuery;

/// Rows of some surfaces.
#[derive(Clone, Debug, Default)]
pub struct RowTable {
    /// Where.
    pub queries: Vec<TransferQuery>,
    /// Lights of the ensemble.
    pub lights: usize,
    /// The mean of both halves under each light, shape [rows, 2 parts, 3 channels, lights]
    /// row-major: base part first, each part over its directional albedo, each light by its weight.
    pub lit: Vec<f32>,
    /// Channel mean under the mean of the weighted lights.
    pub levels: Vec<f32>,
    /// Channels of each half under each weighted light that judges, shape [rows][lights, 2
    /// halves, 3]; empty for rows that do not judge.
    pub judged: Vec<Vec<f32>>,
}

impl RowTable {
    /// How many rows.
    pub fn len(&self) -> usize {
        self.queries.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.queries.is_empty()
    }

    /// Numbers of one part of a row.
    pub fn stride(&self) -> usize {
        3 * self.lights
    }

    /// One part of a row, shape [3 channels, lights].
    #[inline]
    pub fn part(&self, row: usize, part: usize) -> &[f32] {
        let stride = self.stride();
        let first = (2 * row + part) * stride;
        &self.lit[first..first + stride]
    }

    /// Appends further rows under the same lights.
    pub fn append(&mut self, other: RowTable) {
        self.queries.extend(other.queries);
        self.lit.extend(other.lit);
        self.levels.extend(other.levels);
        self.judged.extend(other.judged);
    }
}
