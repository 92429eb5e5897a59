//! What a points table must hold, row by row.

use crate::error::StoreError;
use crate::table::TableRows;
use arrow::datatypes::{DataType, Float32Type, Float64Type};
use rrf_field::columns::{GEOMETRY, N, NAMES, V};

/// Off unit length by more than this is worth telling.
const UNIT_TOLERANCE: f64 = 1e-3;

/// The twelve columns, and how many rows had to be scaled to unit length.
pub(crate) fn geometry(rows: &TableRows) -> Result<([Vec<f32>; GEOMETRY], usize), StoreError> {
    let mut columns: [Vec<f32>; GEOMETRY] = Default::default();
    let missing: Vec<&str> = NAMES
        .iter()
        .take(GEOMETRY)
        .filter(|name| rows.batch.column_by_name(name).is_none())
        .copied()
        .collect();
    if !missing.is_empty() {
        return Err(rows
            .source
            .schema_error(format!("missing: {}", missing.join(" "))));
    }
    for (name, column) in NAMES.iter().zip(&mut columns) {
        *column = read_column(rows, name)?;
    }
    let rescaled = normalise(&mut columns, rows)?;
    Ok((columns, rescaled))
}

fn read_column(rows: &TableRows, name: &str) -> Result<Vec<f32>, StoreError> {
    let values: Vec<f32> = match rows.array(name)?.data_type() {
        DataType::Float32 => rows.numbers::<Float32Type>(name)?.to_vec(),
        DataType::Float64 => {
            let values = rows.numbers::<Float64Type>(name)?;
            values.iter().map(|&x| x as f32).collect()
        }
        other => {
            let difference = format!("column {name}: expected float32 or float64, found {other}");
            return Err(rows.source.schema_error(difference));
        }
    };
    match values.iter().position(|x| !x.is_finite()) {
        None => Ok(values),
        Some(row) => Err(rows
            .source
            .bad_value(name, row, "not a finite float32".into())),
    }
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
