//! `rounds/RRR/fits/cell=CCCCCC/steps.arrow`: the course of a fit, `schemas/steps.toml`.

use super::{path_in, read, write};
use crate::error::StoreError;
use crate::manifest::RunFacts;
use crate::schema::Table;
use crate::table_row;
use std::path::Path;

table_row! {
    /// One accepted step of a fit.
    #[derive(Clone, Debug, PartialEq)]
    pub struct FitStep of Steps {
        /// Accepted steps so far, from 1.
        pub step: u32,
        /// Residuals that the step saw.
        pub residuals: u64,
        /// Mean weighted square residual after it, noise included; `None` where a batch had no step.
        pub cost: Option<f64>,
        /// On the rows that choose the weights, mean, noise taken out.
        pub relative_square_error: Option<f64>,
        /// Damping after it.
        pub damping: f64,
        /// Fall of the cost over the fall promised.
        pub gain: Option<f64>,
    }
}

/// Writes a fit's course into its folder.
///
/// # Errors
/// [`StoreError::Io`].
pub fn write_steps(folder: &Path, steps: &[FitStep], facts: &RunFacts) -> Result<(), StoreError> {
    let steps: Vec<&FitStep> = steps.iter().collect();
    write(&path_in(folder, Table::Steps), &steps, facts, &[])
}

/// Reads a fit's course, in order; `None` where the fit has none written.
///
/// # Errors
/// As [`super::read_tree`].
pub fn read_steps(folder: &Path, facts: &RunFacts) -> Result<Option<Vec<FitStep>>, StoreError> {
    let path = path_in(folder, Table::Steps);
    match path.exists() {
        true => read(&path, facts).map(Some),
        false => Ok(None),
    }
}
