//! Training samples in memory and as a dataset of Parquet parts.

mod columns;
pub mod part_reader;
pub mod parts;

use crate::error::StoreError;
use crate::schema::{self, Table};
use crate::table::{Arrays, RowField};
use arrow::array::RecordBatch;
use columns::column_list;
use rrf_field::columns::Columns;

pub(crate) const CELL_ID: &str = "cell_id";

/// Samples of one cell as parallel columns, as in `schemas/samples.toml`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SampleTable {
    /// The cell that every row belongs to.
    pub cell_id: u32,
    /// Index of each sample in the run.
    pub index: Vec<u64>,
    /// The raw columns; world frame, metres.
    pub columns: Columns,
    /// Material id, `u32::MAX` where there is none.
    pub material: Vec<u32>,
    /// Two independent estimates of the indirect outgoing radiance [W/(sr m^2)], RGB, point
    /// light of 1 W/sr a channel, direct light left out; each the mean of half of the paths.
    pub halves: [Vec<[f32; 3]>; 2],
    /// Paths traced for each row, both halves together.
    pub paths: Vec<u32>,
}

impl SampleTable {
    /// How many rows.
    pub fn len(&self) -> usize {
        self.index.len()
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.index.is_empty()
    }

    /// The estimate from all paths of one row: the mean of its halves. `row` must be below
    /// [`SampleTable::len`].
    pub fn mean(&self, row: usize) -> [f32; 3] {
        std::array::from_fn(|c| 0.5 * (self.halves[0][row][c] + self.halves[1][row][c]))
    }

    /// How many rows hold a value that is not finite.
    pub fn not_finite_rows(&self) -> usize {
        let mut bad = vec![false; self.len()];
        for column in &self.columns.columns {
            for (bad, x) in bad.iter_mut().zip(column) {
                *bad |= !x.is_finite();
            }
        }
        for half in &self.halves {
            for (bad, y) in bad.iter_mut().zip(half) {
                *bad |= !y.iter().all(|y| y.is_finite());
            }
        }
        bad.into_iter().filter(|&bad| bad).count()
    }

    /// The rows as a batch of the `samples` schema.
    ///
    /// # Errors
    /// [`StoreError::Columns`] where columns differ in length.
    pub fn to_batch(&self) -> Result<RecordBatch, StoreError> {
        let mut arrays = Arrays::new();
        u32::write(CELL_ID, &vec![&self.cell_id; self.len()], &mut arrays);
        self.write(&mut arrays);
        schema::table(Table::Samples)?.batch(arrays)
    }
}

column_list! {
    SampleTable {
        index: "sample_index",
        columns: "",
        material: "material_id",
        halves: "y",
        paths: "paths",
    }
}
