//! Training samples in memory, and their columns.

use crate::columns::Source;
use crate::error::StoreError;
use crate::schema::{self, Table};
use arrow::array::{ArrayRef, Float32Array, RecordBatch, UInt32Array, UInt64Array};
use arrow::datatypes::{Float32Type, UInt32Type, UInt64Type};
use rrf_field::columns::{Columns, NAMES};
use std::collections::BTreeMap;
use std::sync::Arc;

pub(crate) const CELL_ID: &str = "cell_id";
const SAMPLE_INDEX: &str = "sample_index";
const MATERIAL_ID: &str = "material_id";
const HALVES: [[&str; 3]; 2] = [["y0_r", "y0_g", "y0_b"], ["y1_r", "y1_g", "y1_b"]];
const PATHS: &str = "paths";

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

    /// Appends the rows of another table.
    pub fn extend(&mut self, other: &SampleTable) {
        self.index.extend_from_slice(&other.index);
        for (column, more) in self.columns.columns.iter_mut().zip(&other.columns.columns) {
            column.extend_from_slice(more);
        }
        self.material.extend_from_slice(&other.material);
        for (half, more) in self.halves.iter_mut().zip(&other.halves) {
            half.extend_from_slice(more);
        }
        self.paths.extend_from_slice(&other.paths);
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
        let mut arrays: BTreeMap<&str, ArrayRef> = BTreeMap::new();
        let cells = vec![self.cell_id; self.len()];
        arrays.insert(CELL_ID, Arc::new(UInt32Array::from(cells)));
        arrays.insert(
            SAMPLE_INDEX,
            Arc::new(UInt64Array::from(self.index.clone())),
        );
        for (name, values) in NAMES.iter().zip(&self.columns.columns) {
            arrays.insert(name, Arc::new(Float32Array::from(values.clone())));
        }
        arrays.insert(
            MATERIAL_ID,
            Arc::new(UInt32Array::from(self.material.clone())),
        );
        for (names, half) in HALVES.iter().zip(&self.halves) {
            for (c, name) in names.iter().enumerate() {
                let values: Float32Array = half.iter().map(|y| y[c]).collect::<Vec<_>>().into();
                arrays.insert(name, Arc::new(values));
            }
        }
        arrays.insert(PATHS, Arc::new(UInt32Array::from(self.paths.clone())));
        schema::table(Table::Samples)?.batch(arrays)
    }

    /// Appends the rows of a batch; their `cell_id` has been compared already.
    pub(crate) fn append(&mut self, batch: &RecordBatch, source: Source) -> Result<(), StoreError> {
        let index = source.values::<UInt64Type>(batch, SAMPLE_INDEX)?;
        self.index.extend_from_slice(index);
        for (name, column) in NAMES.iter().zip(&mut self.columns.columns) {
            column.extend_from_slice(source.values::<Float32Type>(batch, name)?);
        }
        let material = source.values::<UInt32Type>(batch, MATERIAL_ID)?;
        self.material.extend_from_slice(material);
        for (names, half) in HALVES.iter().zip(&mut self.halves) {
            let [r, g, b] = names.map(|name| source.values::<Float32Type>(batch, name));
            let (r, g, b) = (r?, g?, b?);
            half.extend(r.iter().zip(g).zip(b).map(|((r, g), b)| [*r, *g, *b]));
        }
        let paths = source.values::<UInt32Type>(batch, PATHS)?;
        self.paths.extend_from_slice(paths);
        Ok(())
    }
}
