//! `model/metrics.arrow`.

use crate::error::StoreError;
use crate::table::{Arrays, RowField, TableRows};
use crate::table_row;
use rrf_metrics::estimate::SquareError;

table_row! {
    /// How the fit of one cell went, as in `schemas/metrics.toml`.
    #[derive(Clone, Debug, Default, PartialEq)]
    pub struct CellMetrics of Metrics {
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

/// A column's name, and its value of a row.
type Getter<N, T, V> = (N, fn(T) -> V);

/// Four columns, of which the relative error and its standard error are for people.
impl RowField for Option<SquareError> {
    fn write(name: &str, values: &[&Self], to: &mut Arrays) {
        let columns: [Getter<String, SquareError, f64>; 4] = [
            (format!("relative_error_{name}"), |e| e.relative().0),
            (format!("relative_error_{name}_se"), |e| e.relative().1),
            (format!("relative_square_error_{name}"), |e| e.mean),
            (format!("relative_square_error_{name}_se"), |e| e.se),
        ];
        for (name, get) in columns {
            write_each(&name, values, get, to);
        }
    }

    fn read(name: &str, from: &TableRows) -> Result<Vec<Self>, StoreError> {
        let mean = format!("relative_square_error_{name}");
        let both = read_both(&mean, &format!("{mean}_se"), from)?;
        Ok(both
            .map(|both| both.map(|(mean, se)| SquareError { mean, se }))
            .collect())
    }
}

/// The root mean square under the field's name, the median beside it.
impl RowField for Option<Spread> {
    fn write(name: &str, values: &[&Self], to: &mut Arrays) {
        write_each(name, values, |spread| spread.rms, to);
        write_each(
            &format!("{name}_median"),
            values,
            |spread| spread.median,
            to,
        );
    }

    fn read(name: &str, from: &TableRows) -> Result<Vec<Self>, StoreError> {
        let both = read_both(name, &format!("{name}_median"), from)?;
        Ok(both
            .map(|both| both.map(|(rms, median)| Spread { rms, median }))
            .collect())
    }
}

const SEAM_ROWS: &str = "seam_rows";
const SEAM_JUMP: &str = "seam_jump";
const SEAM_CHANGE: &str = "seam_change";

impl RowField for Option<Seams> {
    fn write(_: &str, values: &[&Self], to: &mut Arrays) {
        let rows: Vec<Option<u32>> = values
            .iter()
            .map(|seams| Some(seams.as_ref()?.rows))
            .collect();
        RowField::write(SEAM_ROWS, &rows.iter().collect::<Vec<_>>(), to);
        let spreads: [Getter<&str, &Seams, Option<Spread>>; 2] = [
            (SEAM_JUMP, |seams| seams.jump),
            (SEAM_CHANGE, |seams| seams.change),
        ];
        for (name, get) in spreads {
            let spreads: Vec<Option<Spread>> =
                values.iter().map(|seams| get(seams.as_ref()?)).collect();
            RowField::write(name, &spreads.iter().collect::<Vec<_>>(), to);
        }
    }

    fn read(_: &str, from: &TableRows) -> Result<Vec<Self>, StoreError> {
        let rows: Vec<Option<u32>> = RowField::read(SEAM_ROWS, from)?;
        let jumps: Vec<Option<Spread>> = RowField::read(SEAM_JUMP, from)?;
        let changes: Vec<Option<Spread>> = RowField::read(SEAM_CHANGE, from)?;
        let each = rows.into_iter().zip(jumps).zip(changes);
        let seams = |((rows, jump), change): ((Option<u32>, _), _)| {
            rows.map(|rows| Seams { rows, jump, change })
        };
        Ok(each.map(seams).collect())
    }
}

/// A column of one number of each value, null without a value.
fn write_each<T: Copy>(name: &str, values: &[&Option<T>], get: fn(T) -> f64, to: &mut Arrays) {
    let numbers: Vec<Option<f64>> = values.iter().map(|value| value.map(get)).collect();
    RowField::write(name, &numbers.iter().collect::<Vec<_>>(), to);
}

/// Two columns of which a row has both or none.
fn read_both(
    a: &str,
    b: &str,
    from: &TableRows,
) -> Result<impl Iterator<Item = Option<(f64, f64)>> + use<>, StoreError> {
    let a: Vec<Option<f64>> = RowField::read(a, from)?;
    let b: Vec<Option<f64>> = RowField::read(b, from)?;
    Ok(a.into_iter().zip(b).map(|(a, b)| a.zip(b)))
}
