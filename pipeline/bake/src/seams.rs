//! How much neighbouring nets differ where they meet: the seam columns of `schemas/metrics.toml`.
//!
//! Nothing in a fit makes neighbours agree. Rows held out near a face of their cell are moved onto
//! it and both nets asked; by how much the own net changes a little way inwards says what
//! a difference of that size would look like anyway.

use crate::error::BakeError;
use crate::plan::{CellPlan, RoundPlan};
use crate::run::Run;
use crate::split::is_held_out;
use rayon::prelude::*;
use rrf_field::borders::AXES;
use rrf_field::columns::{COUNT, Columns};
use rrf_field::tree::Domain;
use rrf_field::{Field, FieldError};
use rrf_store::model::{Seams, Spread};
use rrf_store::parts;

/// Rows of a cell that are looked at, at the most: a commit reads no more parts than hold them. The
/// newest are the largest, as they were drawn for the cell as it is and not for its ancestors.
const ROWS: usize = 400;
/// Rows of a part in memory at a time.
const STRETCH: usize = 4096;
/// How near to a face counts, and how far inwards the own net is asked, in sizes of the cell.
const NEAR: f64 = 0.1;

type Row = [f32; COUNT];

/// The seams of every cell, by id; `spans[c]` is what the rows of cell c span.
///
/// # Errors
/// [`BakeError::Store`] for a part that cannot be read.
pub(crate) fn seams(
    run: &Run,
    plan: &RoundPlan,
    field: &Field,
    spans: &[Option<Domain>],
) -> Result<Vec<Seams>, BakeError> {
    let cells = Cells {
        boxes: field.tree().domains(),
        epsilon: epsilon(run.config.train.epsilon, plan.mean_luminance),
        field,
        spans,
    };
    let of_cell = |cell: &CellPlan| Ok(cells.seams(cell.cell as usize, &some_rows(run, cell)?)?);
    plan.cells.par_iter().map(of_cell).collect()
}

/// ε in radiance, as the trainer has it: where all is black, any positive number.
pub(crate) fn epsilon(share: f64, mean_luminance: f32) -> f64 {
    match mean_luminance > 0.0 {
        true => share * f64::from(mean_luminance),
        false => 1.0,
    }
}

/// A cell's first rows held out, its newest part first.
fn some_rows(run: &Run, cell: &CellPlan) -> Result<Columns, BakeError> {
    let (mut rows, facts) = (Columns::default(), run.facts());
    for part in cell.parts.iter().rev() {
        if rows.len() >= ROWS {
            break;
        }
        let place = [cell.cell, part.part];
        parts::each_stretch(&run.folder, place, &facts, STRETCH, &mut |table| {
            let held_out = table.index.iter().map(|&i| is_held_out(facts.seed, i));
            for (row, _) in held_out.enumerate().filter(|&(_, held_out)| held_out) {
                let row = table.columns.row(row);
                if rows.len() < ROWS && row.iter().all(|x| x.is_finite()) {
                    rows.push(row);
                }
            }
        })?;
    }
    Ok(rows)
}

/// The cells as they meet.
struct Cells<'a> {
    field: &'a Field,
    boxes: Vec<Domain>,
    spans: &'a [Option<Domain>],
    epsilon: f64,
}

impl Cells<'_> {
    /// The seams of one cell, by rows of it.
    fn seams(&self, cell: usize, rows: &Columns) -> Result<Seams, FieldError> {
        let (Some(bounds), Some(Some(span))) = (self.boxes.get(cell), self.spans.get(cell)) else {
            return Ok(Seams::default());
        };
        let moved = |row| moved(&rows.row(row), bounds, span);
        let moved: Vec<[Row; 3]> = (0..rows.len())
            .filter_map(moved)
            .filter(|[_, beyond, _]| self.has_seen(beyond))
            .collect();
        let mut asked = Columns::default();
        moved.iter().flatten().for_each(|&row| asked.push(row));
        let mut answers = [const { Vec::new() }; 3];
        self.field.evaluate(&asked, &mut answers, &mut Vec::new())?;
        let [r, g, b] = &answers;
        let rgb = r.iter().zip(g).zip(b).map(|((r, g), b)| [*r, *g, *b]);
        let rgb: Vec<[f64; 3]> = rgb.map(|rgb| rgb.map(f64::from)).collect();
        let (mut jumps, mut changes) = (Vec::new(), Vec::new());
        for answers in rgb.chunks_exact(3) {
            let [own, beyond, within] = [answers[0], answers[1], answers[2]];
            let mean = own.iter().zip(&beyond).map(|(a, b)| a + b).sum::<f64>() / 6.0;
            let divisor = mean.max(self.epsilon);
            jumps.push(square(own, beyond, divisor));
            changes.push(square(own, within, divisor));
        }
        Ok(Seams {
            rows: jumps.len() as u32,
            jump: spread(jumps),
            change: spread(changes),
        })
    }

    /// Whether the cell that a row belongs to was made from such rows. A face may also be where one
    /// object ends and another begins: there the nets never meet.
    fn has_seen(&self, row: &Row) -> bool {
        let cell = self.field.tree().find(row) as usize;
        let span = self.spans.get(cell).copied().flatten();
        span.is_some_and(|span| span.nearly_holds(row))
    }
}

/// A row near a face of its cell, moved onto the cell's side of it, beyond it, and inwards from it;
/// none where no face is near.
fn moved(row: &Row, bounds: &Domain, span: &Domain) -> Option<[Row; 3]> {
    let size = |axis: usize| f64::from(span.maximum[axis]) - f64::from(span.minimum[axis]);
    let (mut nearest, mut least) = (None, NEAR);
    for (low, faces) in [(true, &bounds.minimum), (false, &bounds.maximum)] {
        for axis in AXES {
            let away = (f64::from(row[axis]) - f64::from(faces[axis])).abs() / size(axis);
            if size(axis) > 0.0 && away < least {
                (nearest, least) = (Some((axis, low, faces[axis])), away);
            }
        }
    }
    let (axis, low, face) = nearest?;
    // a row on the face belongs to the cell above it
    let (own, beyond, inwards) = match low {
        true => (face, face.next_down(), NEAR),
        false => (face.next_down(), face, -NEAR),
    };
    let within = (f64::from(own) + inwards * size(axis)) as f32;
    Some([own, beyond, within].map(|x| {
        let mut moved = *row;
        moved[axis] = x;
        moved
    }))
}

/// Mean over the channels of ((a − b) / divisor)².
fn square(a: [f64; 3], b: [f64; 3], divisor: f64) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| ((a - b) / divisor).powi(2));
    squares.sum::<f64>() / 3.0
}

/// Root mean square and median of numbers given as squares.
fn spread(mut squares: Vec<f64>) -> Option<Spread> {
    let rows = squares.len();
    let mean = squares.iter().sum::<f64>() / rows as f64;
    squares.sort_unstable_by(f64::total_cmp);
    let middle = [
        squares.get(rows.checked_sub(1)? / 2)?,
        squares.get(rows / 2)?,
    ];
    Some(Spread {
        rms: mean.sqrt(),
        median: middle.iter().map(|square| square.sqrt()).sum::<f64>() / 2.0,
    })
}

#[cfg(test)]
mod tests;
