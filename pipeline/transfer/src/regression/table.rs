//! Rows as regression sees them: where, and what they hold in the basis.

use crate::query::TransferQuery;

/// Rows projected onto a basis, two independent halves each.
#[derive(Clone, Debug, Default)]
pub struct RowTable {
    /// Where.
    pub queries: Vec<TransferQuery>,
    /// Dimensions of the basis.
    pub rank: usize,
    /// Both halves, shape [rows, 2 parts, rank, 3 channels] row-major: base part first, each part
    /// over its directional albedo.
    pub halves: [Vec<f32>; 2],
    /// Channel mean of each half under the mean of the ensemble's lights [W/(sr m^2)].
    pub levels: Vec<[f32; 2]>,
    /// Channels of each half under each light that judges, shape [rows, lights, 2 halves, 3];
    /// empty for rows that do not judge.
    pub judged: Vec<Vec<f32>>,
    /// Paths of each row.
    pub paths: Vec<u32>,
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
        3 * self.rank
    }

    /// One part of a half of a row, shape [rank, 3].
    #[inline]
    pub fn part(&self, row: usize, half: usize, part: usize) -> &[f32] {
        let stride = self.stride();
        let first = (2 * row + part) * stride;
        &self.halves[half][first..first + stride]
    }

    /// Appends another table of the same basis.
    pub fn extend(&mut self, other: RowTable) {
        self.queries.extend(other.queries);
        self.levels.extend(other.levels);
        self.judged.extend(other.judged);
        self.paths.extend(other.paths);
        for (own, more) in self.halves.iter_mut().zip(other.halves) {
            own.extend(more);
        }
    }
}
