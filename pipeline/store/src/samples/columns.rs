//! Parallel columns in memory as columns of a table.

use crate::error::StoreError;
use crate::table::{Arrays, RowField, TableRows};
use arrow::array::Float32Array;
use arrow::datatypes::Float32Type;
use rrf_field::columns::{Columns, NAMES};
use std::sync::Arc;

/// One or several parallel columns of a table, whose names follow from the one given.
pub(super) trait Column {
    /// Adds the columns.
    fn write(&self, name: &str, to: &mut Arrays);

    /// Appends the values in a file.
    fn read(&mut self, name: &str, from: &TableRows) -> Result<(), StoreError>;

    /// Appends the values of another.
    fn extend(&mut self, other: &Self);
}

impl<T: RowField + Clone> Column for Vec<T> {
    fn write(&self, name: &str, to: &mut Arrays) {
        T::write(name, &self.iter().collect::<Vec<_>>(), to);
    }

    fn read(&mut self, name: &str, from: &TableRows) -> Result<(), StoreError> {
        self.append(&mut T::read(name, from)?);
        Ok(())
    }

    fn extend(&mut self, other: &Self) {
        self.extend_from_slice(other);
    }
}

/// The raw columns, each under its own name.
impl Column for Columns {
    fn write(&self, _: &str, to: &mut Arrays) {
        for (name, values) in NAMES.iter().zip(&self.columns) {
            to.insert(
                name.to_string(),
                Arc::new(Float32Array::from(values.clone())),
            );
        }
    }

    fn read(&mut self, _: &str, from: &TableRows) -> Result<(), StoreError> {
        for (name, column) in NAMES.iter().zip(&mut self.columns) {
            column.extend_from_slice(from.numbers::<Float32Type>(name)?);
        }
        Ok(())
    }

    fn extend(&mut self, other: &Self) {
        for (column, more) in self.columns.iter_mut().zip(&other.columns) {
            column.extend_from_slice(more);
        }
    }
}

/// Two half estimates: `y0_r`, `y0_g`, `y0_b`, `y1_r` and so on.
impl Column for [Vec<[f32; 3]>; 2] {
    fn write(&self, name: &str, to: &mut Arrays) {
        for (names, half) in half_names(name).iter().zip(self) {
            for (c, name) in names.iter().enumerate() {
                let values: Vec<f32> = half.iter().map(|y| y[c]).collect();
                to.insert(name.clone(), Arc::new(Float32Array::from(values)));
            }
        }
    }

    fn read(&mut self, name: &str, from: &TableRows) -> Result<(), StoreError> {
        for (names, half) in half_names(name).iter().zip(self) {
            let [r, g, b] = names
                .each_ref()
                .map(|name| from.numbers::<Float32Type>(name));
            let (r, g, b) = (r?, g?, b?);
            half.extend(r.iter().zip(g).zip(b).map(|((r, g), b)| [*r, *g, *b]));
        }
        Ok(())
    }

    fn extend(&mut self, other: &Self) {
        for (half, more) in self.iter_mut().zip(other) {
            half.extend_from_slice(more);
        }
    }
}

fn half_names(name: &str) -> [[String; 3]; 2] {
    [0, 1].map(|half| ["r", "g", "b"].map(|channel| format!("{name}{half}_{channel}")))
}

/// Gives a struct of parallel columns its writer and reader: each field and the name of its column.
macro_rules! column_list {
    ($table:ident { $($field:ident: $name:literal,)* }) => {
        impl $table {
            /// Adds the columns to those of a batch.
            fn write(&self, to: &mut $crate::table::Arrays) {
                $($crate::samples::columns::Column::write(&self.$field, $name, to);)*
            }

            /// Appends the rows of a file.
            pub(crate) fn read(
                &mut self,
                from: &$crate::table::TableRows,
            ) -> Result<(), $crate::StoreError> {
                $($crate::samples::columns::Column::read(&mut self.$field, $name, from)?;)*
                Ok(())
            }

            /// Appends the rows of another table.
            pub fn extend(&mut self, other: &$table) {
                $($crate::samples::columns::Column::extend(&mut self.$field, &other.$field);)*
            }
        }
    };
}

pub(super) use column_list;
