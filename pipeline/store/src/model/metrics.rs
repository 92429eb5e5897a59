//! `model/metrics.arrow`.

use crate::columns::Source;
use crate::error::StoreError;
use crate::schema::{self, Table};
use arrow::array::{Array, ArrayRef, ArrowPrimitiveType, AsArray, PrimitiveArray};
use arrow::array::{RecordBatch, StringArray};
use arrow::datatypes::{Float64Type, UInt32Type, UInt64Type};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A mean relative square error with the Monte Carlo noise taken out, so that it may be negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SquareError {
    /// The estimate.
    pub mean: f64,
    /// Its standard error.
    pub se: f64,
}

impl SquareError {
    /// The relative error, 0 where the estimate is negative, and its standard error: that of a
    /// square root, se / (2 error), which near 0 gives way to its upper limit sqrt(se).
    pub fn relative(self) -> (f64, f64) {
        let error = self.mean.max(0.0).sqrt();
        let limit = self.se.max(0.0).sqrt();
        let se = if error > 0.0 {
            (self.se / (2.0 * error)).min(limit)
        } else {
            limit
        };
        (error, se)
    }
}

/// A root mean square and a median of the same rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Root mean square.
    pub rms: f64,
    /// Median.
    pub median: f64,
}

/// How a cell's net and its neighbours' differ where they meet, as in `schemas/metrics.toml`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seams {
    /// Rows looked at that are near a face that has a neighbour.
    pub rows: u32,
    /// Relative difference of the two nets; `None` without such rows.
    pub jump: Option<Spread>,
    /// What the own net changes by within a tenth of the cell; `None` without such rows.
    pub change: Option<Spread>,
}

/// How the fit of one cell went, as in `schemas/metrics.toml`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CellMetrics {
    /// The cell.
    pub cell_id: u32,
    /// Round of the bake that fitted it, from 0.
    pub round: u32,
    /// Rows of the cell in `samples/`.
    pub rows: u64,
    /// Rows that the fit used.
    pub train_rows: u64,
    /// Rows held out to choose the best weights.
    pub validation_rows: u64,
    /// Rows left out because a value is not finite or not possible.
    pub quarantined_rows: u64,
    /// Accepted Levenberg-Marquardt steps.
    pub iterations: u32,
    /// Why the fit stopped.
    pub stop_reason: String,
    /// Error on the training rows; `None` without such rows.
    pub train: Option<SquareError>,
    /// Error on the rows held out; `None` without such rows.
    pub validation: Option<SquareError>,
    /// Relative standard error of the targets, from their halves; `None` without rows.
    pub noise: Option<f64>,
    /// Trace of J (JᵀJ + αI)⁻¹ Jᵀ; `None` where not computed.
    pub effective_parameters: Option<f64>,
    /// Weight decay.
    pub alpha: f64,
    /// Damping at the end.
    pub damping: f64,
    /// How many weights the net has.
    pub weights: u32,
    /// Seed of the run.
    pub seed: u64,
    /// Where its net meets others; `None` in a single fit, which knows no neighbours.
    pub seams: Option<Seams>,
}

const ERRORS: [[&str; 4]; 2] = [
    [
        "relative_error_train",
        "relative_error_train_se",
        "relative_square_error_train",
        "relative_square_error_train_se",
    ],
    [
        "relative_error_validation",
        "relative_error_validation_se",
        "relative_square_error_validation",
        "relative_square_error_validation_se",
    ],
];

const JUMP: [&str; 2] = ["seam_jump", "seam_jump_median"];
const CHANGE: [&str; 2] = ["seam_change", "seam_change_median"];

pub(super) fn to_batch(cells: &[CellMetrics]) -> Result<RecordBatch, StoreError> {
    let mut cells: Vec<&CellMetrics> = cells.iter().collect();
    cells.sort_by_key(|cell| cell.cell_id);
    let cells = cells.as_slice();
    let stop: StringArray = cells.iter().map(|c| Some(c.stop_reason.as_str())).collect();
    let mut arrays: BTreeMap<&str, ArrayRef> = BTreeMap::from([
        ("cell_id", values::<UInt32Type>(cells, |c| c.cell_id)),
        ("round", values::<UInt32Type>(cells, |c| c.round)),
        ("rows", values::<UInt64Type>(cells, |c| c.rows)),
        ("train_rows", values::<UInt64Type>(cells, |c| c.train_rows)),
        (
            "validation_rows",
            values::<UInt64Type>(cells, |c| c.validation_rows),
        ),
        (
            "quarantined_rows",
            values::<UInt64Type>(cells, |c| c.quarantined_rows),
        ),
        ("iterations", values::<UInt32Type>(cells, |c| c.iterations)),
        ("stop_reason", Arc::new(stop) as _),
        ("noise", options(cells, |c| c.noise)),
        (
            "effective_parameters",
            options(cells, |c| c.effective_parameters),
        ),
        ("alpha", values::<Float64Type>(cells, |c| c.alpha)),
        ("damping", values::<Float64Type>(cells, |c| c.damping)),
        ("weights", values::<UInt32Type>(cells, |c| c.weights)),
        ("seed", values::<UInt64Type>(cells, |c| c.seed)),
    ]);
    let which: [fn(&CellMetrics) -> Option<SquareError>; 2] = [|c| c.train, |c| c.validation];
    for (names, get) in ERRORS.iter().zip(which) {
        let [error, error_se, square, square_se] = *names;
        arrays.insert(error, options(cells, |c| get(c).map(|e| e.relative().0)));
        arrays.insert(error_se, options(cells, |c| get(c).map(|e| e.relative().1)));
        arrays.insert(square, options(cells, |c| get(c).map(|e| e.mean)));
        arrays.insert(square_se, options(cells, |c| get(c).map(|e| e.se)));
    }
    let rows: PrimitiveArray<UInt32Type> = cells.iter().map(|c| Some(c.seams?.rows)).collect();
    arrays.insert("seam_rows", Arc::new(rows));
    let which: [fn(&CellMetrics) -> Option<Spread>; 2] = [|c| c.seams?.jump, |c| c.seams?.change];
    for ([rms, median], get) in [JUMP, CHANGE].into_iter().zip(which) {
        arrays.insert(rms, options(cells, |c| Some(get(c)?.rms)));
        arrays.insert(median, options(cells, |c| Some(get(c)?.median)));
    }
    schema::table(Table::Metrics)?.batch(arrays)
}

fn values<T: ArrowPrimitiveType>(
    cells: &[&CellMetrics],
    get: impl Fn(&CellMetrics) -> T::Native,
) -> ArrayRef {
    let values = cells.iter().map(|&cell| get(cell));
    Arc::new(PrimitiveArray::<T>::from_iter_values(values))
}

fn options(cells: &[&CellMetrics], get: impl Fn(&CellMetrics) -> Option<f64>) -> ArrayRef {
    let values: PrimitiveArray<Float64Type> = cells.iter().map(|&cell| get(cell)).collect();
    Arc::new(values)
}

pub(super) fn from_batch(
    batch: &RecordBatch,
    source: Source,
) -> Result<Vec<CellMetrics>, StoreError> {
    let rows = Rows { batch, source };
    (0..batch.num_rows()).map(|row| rows.cell(row)).collect()
}

struct Rows<'a> {
    batch: &'a RecordBatch,
    source: Source<'a>,
}

impl Rows<'_> {
    fn cell(&self, row: usize) -> Result<CellMetrics, StoreError> {
        let u32 = |name| self.value::<UInt32Type>(name, row);
        let u64 = |name| self.value::<UInt64Type>(name, row);
        let f64 = |name| self.value::<Float64Type>(name, row);
        Ok(CellMetrics {
            cell_id: u32("cell_id")?,
            round: u32("round")?,
            rows: u64("rows")?,
            train_rows: u64("train_rows")?,
            validation_rows: u64("validation_rows")?,
            quarantined_rows: u64("quarantined_rows")?,
            iterations: u32("iterations")?,
            stop_reason: self.text("stop_reason", row)?,
            train: self.square(ERRORS[0], row)?,
            validation: self.square(ERRORS[1], row)?,
            noise: self.option::<Float64Type>("noise", row)?,
            effective_parameters: self.option::<Float64Type>("effective_parameters", row)?,
            alpha: f64("alpha")?,
            damping: f64("damping")?,
            weights: u32("weights")?,
            seed: u64("seed")?,
            seams: self.seams(row)?,
        })
    }

    fn value<T: ArrowPrimitiveType>(
        &self,
        name: &str,
        row: usize,
    ) -> Result<T::Native, StoreError> {
        let value = self.option::<T>(name, row)?;
        value.ok_or_else(|| self.source.null(name, row))
    }

    fn option<T: ArrowPrimitiveType>(
        &self,
        name: &str,
        row: usize,
    ) -> Result<Option<T::Native>, StoreError> {
        let array = self.source.nullable::<T>(self.batch, name)?;
        Ok((!array.is_null(row)).then(|| array.value(row)))
    }

    /// Two columns of which a row has both or none.
    fn both(&self, [a, b]: [&str; 2], row: usize) -> Result<Option<(f64, f64)>, StoreError> {
        let a = self.option::<Float64Type>(a, row)?;
        Ok(a.zip(self.option::<Float64Type>(b, row)?))
    }

    fn square(&self, names: [&str; 4], row: usize) -> Result<Option<SquareError>, StoreError> {
        let [_, _, mean, se] = names;
        let both = self.both([mean, se], row)?;
        Ok(both.map(|(mean, se)| SquareError { mean, se }))
    }

    fn seams(&self, row: usize) -> Result<Option<Seams>, StoreError> {
        let spread = |names| -> Result<Option<Spread>, StoreError> {
            let both = self.both(names, row)?;
            Ok(both.map(|(rms, median)| Spread { rms, median }))
        };
        let Some(rows) = self.option::<UInt32Type>("seam_rows", row)? else {
            return Ok(None);
        };
        Ok(Some(Seams {
            rows,
            jump: spread(JUMP)?,
            change: spread(CHANGE)?,
        }))
    }

    fn text(&self, name: &str, row: usize) -> Result<String, StoreError> {
        let array = self.source.array(self.batch, name)?;
        let strings = array.as_string_opt::<i32>();
        let strings =
            strings.ok_or_else(|| self.source.schema_error(format!("column {name}: not utf8")))?;
        let value = (!strings.is_null(row)).then(|| strings.value(row).to_string());
        value.ok_or_else(|| self.source.null(name, row))
    }
}
