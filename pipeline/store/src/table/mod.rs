//! Rows in memory and columns in files: a column is declared once, as a field of the row that
//! [`table_row!`](crate::table_row) defines, in the words of `schemas/`.
//!
//! Writing and reading follow from the field's name and type: numbers, texts and lists are a column of
//! the field's name ([`Value`]), absent ones of an `Option` null; a type may also be several columns
//! ([`RowField`]).

mod field;
mod source;
mod value;

pub use crate::schema::Arrays;
pub use field::{RowField, TableRow};
pub(crate) use source::Source;
pub use source::TableRows;
pub use value::Value;

/// Defines the row of a table: its fields are the columns of `schemas/`.
///
/// ```
/// rrf_store::table_row! {
///     /// One accepted step, some columns left out.
///     #[derive(Clone, Debug, PartialEq)]
///     pub struct Step of Steps {
///         /// Accepted steps so far.
///         pub step: u32,
///         /// Mean weighted square residual.
///         pub cost: Option<f64>,
///     }
/// }
/// ```
#[macro_export]
macro_rules! table_row {
    (
        $(#[$about:meta])*
        $vis:vis struct $row:ident of $table:ident {
            $($(#[$note:meta])* $field_vis:vis $field:ident: $type:ty,)*
        }
    ) => {
        $(#[$about])*
        $vis struct $row {
            $($(#[$note])* $field_vis $field: $type,)*
        }

        impl $crate::table::TableRow for $row {
            const TABLE: $crate::schema::Table = $crate::schema::Table::$table;

            fn write(rows: &[&Self], to: &mut $crate::table::Arrays) {
                $(
                    let values: Vec<&$type> = rows.iter().map(|row| &row.$field).collect();
                    <$type as $crate::table::RowField>::write(stringify!($field), &values, to);
                )*
            }

            fn read(from: &$crate::table::TableRows) -> Result<Vec<Self>, $crate::StoreError> {
                $(
                    let values = <$type as $crate::table::RowField>::read(stringify!($field), from)?;
                    let mut $field = values.into_iter();
                )*
                let row = || Some($row { $($field: $field.next()?,)* });
                Ok(std::iter::from_fn(row).collect())
            }
        }
    };
}
