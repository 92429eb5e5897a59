//! Column `light` of a points table: names of lights, row by row.

use crate::error::StoreError;
use crate::table::TableRows;
use arrow::array::{Array, AsArray};
use arrow::compute::cast;
use arrow::datatypes::DataType;
use std::collections::HashMap;

/// Name of a row's own point light of 1 W/sr, at l: of rows without a name too.
pub const POINT: &str = "point";
/// Name of a row's own sun of 1 W/m², l the unit direction toward it.
pub const SUN: &str = "sun";

/// The column.
const LIGHT: &str = "light";

/// Names, the first [`POINT`], and each row's number among them; rows without a name, and all rows
/// where there is no such column, have [`POINT`].
pub(super) fn lights(rows: &TableRows) -> Result<(Vec<String>, Vec<u32>), StoreError> {
    let mut names = vec![POINT.to_string()];
    let mut ids = vec![0; rows.batch.num_rows()];
    let Some(column) = rows.batch.column_by_name(LIGHT) else {
        return Ok((names, ids));
    };
    let wrong = || rows.wrong_type(LIGHT, column.as_ref());
    if !is_text(column.data_type()) {
        return Err(wrong());
    }
    let text = cast(column.as_ref(), &DataType::Utf8).map_err(|_| wrong())?;
    let text = text.as_string_opt::<i32>().ok_or_else(wrong)?;
    let mut known = HashMap::from([(POINT, 0)]);
    for (id, name) in ids.iter_mut().zip(text) {
        let name = name.unwrap_or(POINT);
        *id = *known.entry(name).or_insert_with(|| {
            names.push(name.to_string());
            names.len() as u32 - 1
        });
    }
    Ok((names, ids))
}

fn is_text(kind: &DataType) -> bool {
    match kind {
        DataType::Utf8 | DataType::LargeUtf8 | DataType::Utf8View | DataType::Null => true,
        DataType::Dictionary(_, values) => is_text(values),
        _ => false,
    }
}

/// Rows whose light is the scene's own, so that l says nothing.
pub(super) fn own_lights(names: &[String], ids: &[u32]) -> Vec<bool> {
    let own: Vec<bool> = names.iter().map(|n| n != POINT && n != SUN).collect();
    let of = |id: &u32| own.get(*id as usize).copied().unwrap_or(false);
    ids.iter().map(of).collect()
}
