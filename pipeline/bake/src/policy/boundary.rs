//! Discontinuity between neighbouring nets at the boundaries of their cells: the seam columns of
//! `schemas/metrics.toml`.
//!
//! Nothing in a fit makes neighbours agree. Held-out rows near a face of their cell are moved onto it,
//! and both nets are evaluated. How much the cell's own net changes a little way inwards says how
//! large a difference of that size is in the scene itself.

use rrf_field::borders::AXES;
use rrf_field::columns::{COUNT, Columns};
use rrf_field::tree::Domain;
use rrf_field::{Field, FieldError};
use rrf_store::model::{Seams, Spread};

/// Distance to a face that counts as near, and distance inwards at which the cell's own net is
/// evaluated, as shares of the cell's size.
const NEAR: f64 = 0.1;

type Row = [f32; COUNT];

/// The cells of a field and their neighbours.
pub(crate) struct Boundaries<'a> {
    field: &'a Field,
    boxes: Vec<Domain>,
    spans: &'a [Option<Domain>],
    floor: f64,
}

impl<'a> Boundaries<'a> {
    /// Of a field; `spans[c]` is the box that the rows of cell c span, `floor` the smallest divisor
    /// [W·sr⁻¹·m⁻²].
    pub fn new(field: &'a Field, spans: &'a [Option<Domain>], floor: f64) -> Boundaries<'a> {
        Boundaries {
            boxes: field.tree().domains(),
            field,
            spans,
            floor,
        }
    }

    /// The discontinuity at the faces of one cell, measured at rows of it.
    ///
    /// # Errors
    /// [`FieldError`] for rows that no cell can be found for.
    pub fn discontinuity(&self, cell: usize, rows: &Columns) -> Result<Seams, FieldError> {
        let (Some(bounds), Some(Some(span))) = (self.boxes.get(cell), self.spans.get(cell)) else {
            return Ok(Seams::default());
        };
        let moved = |row| moved(&rows.row(row), bounds, span);
        let moved: Vec<[Row; 3]> = (0..rows.len())
            .filter_map(moved)
            .filter(|[_, beyond, _]| self.is_covered(beyond))
            .collect();
        let mut points = Columns::default();
        moved.iter().flatten().for_each(|&row| points.push(row));
        let mut radiance = [const { Vec::new() }; 3];
        self.field
            .evaluate(&points, &mut radiance, &mut Vec::new())?;
        let [r, g, b] = &radiance;
        let rgb = r.iter().zip(g).zip(b).map(|((r, g), b)| [*r, *g, *b]);
        let rgb: Vec<[f64; 3]> = rgb.map(|rgb| rgb.map(f64::from)).collect();
        let (mut jumps, mut changes) = (Vec::new(), Vec::new());
        for three in rgb.chunks_exact(3) {
            let [own, beyond, within] = [three[0], three[1], three[2]];
            let mean = own.iter().zip(&beyond).map(|(a, b)| a + b).sum::<f64>() / 6.0;
            let divisor = mean.max(self.floor);
            jumps.push(square(own, beyond, divisor));
            changes.push(square(own, within, divisor));
        }
        Ok(Seams {
            rows: jumps.len() as u32,
            jump: spread(jumps),
            change: spread(changes),
        })
    }

    /// Whether the cell of a row was fitted to such rows. A face may also lie where one object ends and
    /// another begins: there the nets never meet.
    fn is_covered(&self, row: &Row) -> bool {
        let cell = self.field.tree().find(row) as usize;
        let span = self.spans.get(cell).copied().flatten();
        span.is_some_and(|span| span.nearly_holds(row))
    }
}

/// A row near a face of its cell, moved onto the cell's side of the face, beyond it, and inwards from
/// it; none where no face is near.
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
