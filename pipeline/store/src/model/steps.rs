//! `rounds/RRR/fits/cell=CCCCCC/steps.arrow`: the course of a fit, `schemas/steps.toml`.

use super::fit::table_path;
use super::{read, source, write};
use crate::columns::Source;
use crate::error::StoreError;
use crate::manifest::RunFacts;
use crate::schema::{self, Table};
use arrow::array::{Array, ArrayRef, ArrowPrimitiveType, PrimitiveArray, RecordBatch};
use arrow::datatypes::{Float64Type, UInt32Type, UInt64Type};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

/// One accepted step of a fit.
#[derive(Clone, Debug, PartialEq)]
pub struct FitStep {
    /// Accepted steps so far, from 1.
    pub step: u32,
    /// Residuals that the step saw.
    pub residuals: u64,
    /// Mean weighted square residual after it, noise included; `None` where a batch had no step.
    pub cost: Option<f64>,
    /// Mean relative square error on the rows that choose the weights, noise taken out.
    pub square_error: Option<f64>,
    /// Damping after it.
    pub damping: f64,
    /// Fall of the cost over the fall promised.
    pub gain: Option<f64>,
}

/// Writes a fit's course into its folder.
///
/// # Errors
/// [`StoreError::Io`].
pub fn write_steps(folder: &Path, steps: &[FitStep], facts: &RunFacts) -> Result<(), StoreError> {
    let arrays: BTreeMap<&str, ArrayRef> = BTreeMap::from([
        ("step", values::<UInt32Type>(steps, |s| Some(s.step))),
        (
            "residuals",
            values::<UInt64Type>(steps, |s| Some(s.residuals)),
        ),
        ("cost", values::<Float64Type>(steps, |s| s.cost)),
        (
            "relative_square_error",
            values::<Float64Type>(steps, |s| s.square_error),
        ),
        ("damping", values::<Float64Type>(steps, |s| Some(s.damping))),
        ("gain", values::<Float64Type>(steps, |s| s.gain)),
    ]);
    let batch = schema::table(Table::Steps)?.batch(arrays)?;
    write(
        &table_path(folder, Table::Steps),
        Table::Steps,
        batch,
        facts,
    )
}

/// Reads a fit's course, in order; `None` where the fit has none written.
///
/// # Errors
/// As [`super::read_tree`].
pub fn read_steps(folder: &Path, facts: &RunFacts) -> Result<Option<Vec<FitStep>>, StoreError> {
    let path = table_path(folder, Table::Steps);
    if !path.exists() {
        return Ok(None);
    }
    let batch = read(&path, Table::Steps, facts)?;
    let source = source(&path, Table::Steps);
    let steps = (0..batch.num_rows()).map(|row| step(&batch, &source, row));
    steps.collect::<Result<_, _>>().map(Some)
}

fn step(batch: &RecordBatch, source: &Source, row: usize) -> Result<FitStep, StoreError> {
    fn option<T: ArrowPrimitiveType>(
        batch: &RecordBatch,
        source: &Source,
        name: &str,
        row: usize,
    ) -> Result<Option<T::Native>, StoreError> {
        let array = source.nullable::<T>(batch, name)?;
        Ok((!array.is_null(row)).then(|| array.value(row)))
    }
    let real = |name| option::<Float64Type>(batch, source, name, row);
    let null = |name| source.null(name, row);
    Ok(FitStep {
        step: option::<UInt32Type>(batch, source, "step", row)?.ok_or_else(|| null("step"))?,
        residuals: option::<UInt64Type>(batch, source, "residuals", row)?
            .ok_or_else(|| null("residuals"))?,
        cost: real("cost")?,
        square_error: real("relative_square_error")?,
        damping: real("damping")?.ok_or_else(|| null("damping"))?,
        gain: real("gain")?,
    })
}

fn values<T: ArrowPrimitiveType>(
    steps: &[FitStep],
    get: impl Fn(&FitStep) -> Option<T::Native>,
) -> ArrayRef {
    let values: PrimitiveArray<T> = steps.iter().map(get).collect();
    Arc::new(values)
}
