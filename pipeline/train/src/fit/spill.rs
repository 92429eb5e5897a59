//! Fitting a cell whose rows are too many for memory: they are read piece by piece and put into
//! a file in the order of their use, which the fit then reads from beginning to end at each pass.
//!
//! The sums are those of [`crate::fit_cell`], term by term, and so are the bits of the result.

use super::fit_prepared;
use crate::cell::Preparation;
use crate::config::TrainConfig;
use crate::error::TrainError;
use crate::report::CellFit;
use crate::rows::chunk::Chunk;
use crate::rows::order::{OrderedRows, Uses};
use crate::rows::samples::Samples;
use crate::rows::scratch::Scratch;
use crate::start::Start;
use std::fs::File;
use std::io;
use std::rc::Rc;

/// Bytes a row while the file is written: its key, its number and its place.
pub const ORDERED_ROW: u64 = 16;
/// Bytes a row that stay in memory afterwards, at most while the error of the fit is told: the
/// divisor of the row, its weight in the sums and its share of the error.
pub const HELD_ROW: u64 = 24;
/// Bytes that windows of rows take, whatever their number.
pub const WINDOWS: u64 = 8 << 20;

/// Why a fit from a file has no result.
#[derive(Debug, thiserror::Error)]
pub enum SpillError<E: std::error::Error + 'static> {
    /// The fit cannot start.
    #[error(transparent)]
    Train(#[from] TrainError),
    /// The rows cannot be read.
    #[error(transparent)]
    Rows(E),
    /// The scratch file cannot be written or read.
    #[error("the scratch file of a fit cannot be used: {0}")]
    Scratch(io::Error),
}

/// [`crate::fit_from`] with rows that `pass` hands on piece by piece, the same at every call, and
/// `scratch`, an empty file open for reading and writing, to keep them in.
pub fn fit_spilled<E: std::error::Error>(
    start: Start,
    cell: u32,
    pass: impl Fn(&mut dyn FnMut(&Samples)) -> Result<(), E>,
    scratch: &File,
    config: &TrainConfig,
) -> Result<CellFit, SpillError<E>> {
    let preparation = Preparation::new(cell, start, config)?;
    let mut order = preparation.order();
    let mut faulty = None;
    pass(&mut |piece| match piece.check() {
        Ok(()) => preparation.add(piece, &mut order),
        Err(error) => faulty = Some(error),
    })
    .map_err(SpillError::Rows)?;
    if let Some(error) = faulty {
        return Err(error.into());
    }
    let uses = order.finish();
    let used = uses.train.len() + uses.validation.len();
    let scratch = Rc::new(Scratch::new(scratch, used));
    fill(&scratch, &uses, pass)?;
    let raw = OrderedRows::Spilled(scratch.clone());
    let fit = fit_prepared(preparation.finish(raw, uses));
    match scratch.failure() {
        Some(failure) => Err(SpillError::Scratch(failure)),
        None => Ok(fit?),
    }
}

/// Puts every row that is used where it is used.
fn fill<E: std::error::Error>(
    scratch: &Scratch,
    uses: &Uses,
    pass: impl Fn(&mut dyn FnMut(&Samples)) -> Result<(), E>,
) -> Result<(), SpillError<E>> {
    let places = uses.places();
    let (mut row, mut written) = (0, Ok(()));
    pass(&mut |piece| {
        let rows = piece.rows.len() as u32;
        let chunk = Chunk::gathered(piece, 0..rows);
        let places = places.get(row..).unwrap_or_default();
        for (at, place) in (0..chunk.len()).zip(places) {
            if let (Some(place), Ok(())) = (place, &written) {
                written = scratch.write(place.get() as usize - 1, &chunk.row(at));
            }
        }
        row += chunk.len();
    })
    .map_err(SpillError::Rows)?;
    if row != uses.rows {
        return Err(SpillError::Train(TrainError::Length {
            what: "a second pass",
            found: row,
            expected: uses.rows,
        }));
    }
    written.map_err(SpillError::Scratch)
}
