//! What a points table must hold, row by row.

use crate::error::StoreError;
use crate::table::TableRows;
use arrow::array::AsArray;
use arrow::datatypes::{DataType, Float32Type, Float64Type};
use rrf_field::columns::{GEOMETRY, L, N, NAMES, V};

/// Off unit length by more than this is worth telling.
const UNIT_TOLERANCE: f64 = 1e-3;

/// Refuses a table without one of the twelve columns, or with one of another type. Only then its number of
/// rows is to be believed: without values it may be any.
pub(crate) fn expect_columns(rows: &TableRows) -> Result<(), StoreError> {
    let columns = || NAMES.iter().take(GEOMETRY);
    let is_missing = |name: &&&str| rows.batch.column_by_name(name).is_none();
    let missing: Vec<&str> = columns().filter(is_missing).copied().collect();
    if !missing.is_empty() {
        return Err(rows
            .source
            .schema_error(format!("missing: {}", missing.join(" "))));
    }
    for name in columns() {
        match rows.array(name)?.data_type() {
            DataType::Float32 | DataType::Float64 => {}
            other => return Err(wrong_type(rows, name, other)),
        }
    }
    Ok(())
}

fn wrong_type(rows: &TableRows, name: &str, found: &DataType) -> StoreError {
    let difference = format!("column {name}: expected float32 or float64, found {found}");
    rows.source.schema_error(difference)
}

/// The twelve columns, and how many rows had to be scaled to unit length; l is not read in rows
/// whose light is the scene's own.
pub(crate) fn geometry(
    rows: &TableRows,
    own_light: &[bool],
) -> Result<([Vec<f32>; GEOMETRY], usize), StoreError> {
    let mut columns: [Vec<f32>; GEOMETRY] = Default::default();
    for (c, (name, column)) in NAMES.iter().zip(&mut columns).enumerate() {
        let unread = |row: usize| c >= L && own_light.get(row).copied().unwrap_or(false);
        *column = read_column(rows, name, unread)?;
    }
    let rescaled = normalise(&mut columns, rows)?;
    Ok((columns, rescaled))
}

/// A column of finite numbers; zero in rows that are not read.
fn read_column(
    rows: &TableRows,
    name: &str,
    unread: impl Fn(usize) -> bool,
) -> Result<Vec<f32>, StoreError> {
    let array = rows.array(name)?;
    let values: Vec<Option<f32>> = match array.data_type() {
        DataType::Float32 => array.as_primitive::<Float32Type>().iter().collect(),
        DataType::Float64 => {
            let values = array.as_primitive::<Float64Type>().iter();
            values.map(|x| x.map(|x| x as f32)).collect()
        }
        other => return Err(wrong_type(rows, name, other)),
    };
    let read = values.into_iter().enumerate().map(|(row, value)| {
        if unread(row) {
            return Ok(0.0);
        }
        match value {
            Some(x) if x.is_finite() => Ok(x),
            Some(_) => {
                let reason = "not a finite float32".into();
                Err(rows.source.bad_value(name, row, reason))
            }
            None => Err(rows.null(name, row)),
        }
    });
    read.collect()
}

/// Scales n and v to unit length, and finds rows whose viewer is below the surface.
fn normalise(columns: &mut [Vec<f32>; GEOMETRY], rows: &TableRows) -> Result<usize, StoreError> {
    let mut rescaled = 0;
    for row in 0..columns[0].len() {
        let (n, off_n) = unit(columns, N, row, rows)?;
        let (v, off_v) = unit(columns, V, row, rows)?;
        let cosine = n[0] * v[0] + n[1] * v[1] + n[2] * v[2];
        if cosine <= 0.0 {
            let reason = format!(
                "the viewer is below the surface (n . v = {cosine:.3}); \
                 the normal must be on the side that is seen"
            );
            return Err(rows.source.bad_value(NAMES[V], row, reason));
        }
        rescaled += usize::from(off_n.max(off_v) > UNIT_TOLERANCE);
        for c in 0..3 {
            columns[N + c][row] = n[c] as f32;
            columns[V + c][row] = v[c] as f32;
        }
    }
    Ok(rescaled)
}

/// Three columns of a row at unit length, and how far off they were.
fn unit(
    columns: &[Vec<f32>; GEOMETRY],
    first: usize,
    row: usize,
    rows: &TableRows,
) -> Result<([f64; 3], f64), StoreError> {
    let x: [f64; 3] = std::array::from_fn(|c| f64::from(columns[first + c][row]));
    let length = (x[0] * x[0] + x[1] * x[1] + x[2] * x[2]).sqrt();
    if length == 0.0 {
        let reason = "a direction of length zero".to_string();
        return Err(rows.source.bad_value(NAMES[first], row, reason));
    }
    Ok((x.map(|x| x / length), (length - 1.0).abs()))
}
