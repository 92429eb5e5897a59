//! Cells blended where they meet.
//!
//! Nothing in a fit makes neighbouring nets agree. Near a face of its cell's box a row is given to the net
//! beyond it as well. With d its distance to the face in sizes of the cell, that net counts for ½ (1 − d / [`MARGIN`])
//! where both agree, half at the face from either side; less where they differ, and not at all where one
//! of them guesses: beyond twice [`AGREED`] apart, or where the cell beyond was made from no such rows.

use super::field::Field;
use crate::columns::{self, COUNT, Columns};
use crate::error::FieldError;
use crate::tree::Domain;

/// Up to where a neighbour counts, in sizes of the cell.
pub const MARGIN: f32 = 0.1;
/// Relative difference of two nets up to which the neighbour counts in full.
pub const AGREED: f32 = 0.25;
/// Columns whose faces count: p, v and l.
pub const AXES: [usize; 9] = {
    let (p, v, l) = (columns::P, columns::V, columns::L);
    [p, p + 1, p + 2, v, v + 1, v + 2, l, l + 1, l + 2]
};

/// The cells' boxes and what their rows span.
#[derive(Clone, Debug)]
pub struct Borders {
    boxes: Vec<Domain>,
    spans: Vec<Option<Domain>>,
}

/// A row near a face: which, the cell beyond, and its share where the two agree.
struct Near {
    row: u32,
    beyond: u32,
    share: f32,
}

impl Borders {
    /// Of a field whose cells span `spans`, by cell.
    pub fn new(field: &Field, spans: Vec<Option<Domain>>) -> Borders {
        Borders {
            boxes: field.tree().domains(),
            spans,
        }
    }

    /// [`Field::evaluate`] with neighbours blended in. A row's bits do not depend on the others.
    ///
    /// # Errors
    /// As [`Field::evaluate`].
    pub fn evaluate(
        &self,
        field: &Field,
        rows: &Columns,
        out: &mut [Vec<f32>; 3],
        cells: &mut Vec<u32>,
    ) -> Result<(), FieldError> {
        field.evaluate(rows, out, cells)?;
        let mut near = Vec::new();
        for (row, &cell) in cells.iter().enumerate() {
            self.near(field, row as u32, &rows.row(row), cell as usize, &mut near);
        }
        let (asked, beyond): (Vec<u32>, Vec<u32>) = near.iter().map(|n| (n.row, n.beyond)).unzip();
        let mut others: [Vec<f32>; 3] = Default::default();
        field.evaluate_as(&rows.take(&asked), &beyond, &mut others)?;
        let rgb = |of: &[Vec<f32>; 3], at: usize| [of[0][at], of[1][at], of[2][at]];
        let mut first = 0;
        for near in near.chunk_by(|a, b| a.row == b.row) {
            let row = near.first().map_or(0, |n| n.row as usize);
            let own = rgb(out, row);
            let (mut sum, mut total) = (own, 1.0);
            for (k, near) in (first..).zip(near) {
                let other = rgb(&others, k);
                let share = near.share * agreement(own, other);
                let weight = share / (1.0 - share);
                total += weight;
                sum.iter_mut()
                    .zip(other)
                    .for_each(|(sum, y)| *sum += weight * y);
            }
            out.iter_mut()
                .zip(sum)
                .for_each(|(out, y)| out[row] = y / total);
            first += near.len();
        }
        Ok(())
    }

    /// The faces that a row is near to and that have a neighbour.
    fn near(&self, field: &Field, id: u32, row: &[f32; COUNT], cell: usize, near: &mut Vec<Near>) {
        let (Some(bounds), Some(Some(span))) = (self.boxes.get(cell), self.spans.get(cell)) else {
            return;
        };
        for axis in AXES {
            let size = span.maximum[axis] - span.minimum[axis];
            for (low, face) in [(true, bounds.minimum[axis]), (false, bounds.maximum[axis])] {
                let away = (row[axis] - face).abs() / size;
                if !(size > 0.0 && away < MARGIN) {
                    continue;
                }
                let mut over = *row;
                // a row on the face belongs to the cell above it
                over[axis] = if low { face.next_down() } else { face };
                let beyond = field.tree().find(&over);
                if self.has_seen(beyond, &over) {
                    near.push(Near {
                        row: id,
                        beyond,
                        share: 0.5 * (1.0 - away / MARGIN),
                    });
                }
            }
        }
    }

    /// Whether a cell was made from such rows: a face may also be where one object ends and another
    /// begins, and there nets never meet.
    fn has_seen(&self, cell: u32, row: &[f32; COUNT]) -> bool {
        let span = self.spans.get(cell as usize);
        span.is_some_and(|span| span.is_some_and(|span| span.nearly_holds(row)))
    }
}

/// 1 where two nets differ by no more than [`AGREED`] of their mean, 0 from twice that on.
fn agreement(a: [f32; 3], b: [f32; 3]) -> f32 {
    let mean = a.iter().chain(&b).sum::<f32>() / 6.0;
    let square = |(a, b): (&f32, &f32)| ((a - b) / mean).powi(2);
    let apart = (a.iter().zip(&b).map(square).sum::<f32>() / 3.0).sqrt();
    // both black: not a number, and nothing to blend
    (2.0 - apart / AGREED).clamp(0.0, 1.0).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::net::Shape;
    use crate::model::{CellModel, Kind};
    use crate::tree::Tree;

    /// The model of one colour.
    fn plain(cell: u32, y: [f32; 3]) -> CellModel {
        CellModel {
            cell,
            kind: Kind::Net,
            inputs: Vec::new(),
            input_offset: Vec::new(),
            input_scale: Vec::new(),
            shape: Shape { sizes: vec![0, 3] },
            weights: vec![0.0; 3],
            output_scale: [1.0; 3],
            output_offset: y,
            divide_base: false,
            exponential: false,
        }
    }

    /// Two cells that part px at 0, of one colour each, and what their rows span.
    fn blended(a: [f32; 3], b: [f32; 3], spans: [Option<Domain>; 2], px: &[f32]) -> Vec<[f32; 3]> {
        let mut tree = Tree::single();
        tree.split(0, columns::P, 0.0, 1);
        let field = Field::new(tree, vec![plain(0, a), plain(1, b)]).unwrap();
        let mut rows = Columns::default();
        for &x in px {
            let mut row = [0.5; COUNT];
            row[columns::P] = x;
            rows.push(row);
        }
        let (mut out, mut cells) = (Default::default(), Vec::new());
        let borders = Borders::new(&field, spans.to_vec());
        borders
            .evaluate(&field, &rows, &mut out, &mut cells)
            .unwrap();
        let [r, g, b] = out;
        (0..px.len()).map(|k| [r[k], g[k], b[k]]).collect()
    }

    fn spans() -> [Option<Domain>; 2] {
        let span = |low: f32, high: f32| {
            let (mut least, mut most) = ([0.5; COUNT], [0.5; COUNT]);
            (least[columns::P], most[columns::P]) = (low, high);
            Some(Domain {
                minimum: least,
                maximum: most,
            })
        };
        [span(-2.0, 0.0), span(0.0, 1.0)]
    }

    /// At the face both sides come to the mean; a margin away (0.2 and 0.1) nothing is left; halfway the
    /// neighbour counts for a quarter.
    #[test]
    fn neighbours_that_agree_meet_halfway() {
        let (a, b) = ([1.0; 3], [1.2; 3]);
        let found = blended(a, b, spans(), &[-1e-7, 0.0, -0.1, 0.05, -0.2, 0.1, -1.0]);
        let expected = [1.1, 1.1, 1.05, 1.15, 1.0, 1.2, 1.0];
        for (found, expected) in found.iter().zip(expected) {
            for y in found {
                assert!((y - expected).abs() < 1e-5, "{y} {expected}");
            }
        }
    }

    /// Nets that are far apart, or a neighbour that has seen no such rows, change nothing.
    #[test]
    fn a_neighbour_that_guesses_is_left_out() {
        let (a, b) = ([1.0; 3], [1.7; 3]);
        assert_eq!(blended(a, b, spans(), &[-1e-7, 0.0]), [a, b]);
        let [first, second] = spans();
        let elsewhere = second.map(|mut span| {
            (span.minimum[columns::N], span.maximum[columns::N]) = (0.9, 1.0);
            span
        });
        let b = [1.1; 3];
        assert_eq!(blended(a, b, [first, elsewhere], &[-1e-7]), [a]);
        assert_eq!(blended(a, b, [first, None], &[-1e-7]), [a]);
        assert_eq!(blended([0.0; 3], [0.0; 3], spans(), &[0.0]), [[0.0; 3]]);
    }

    /// At a corner each neighbour counts as much as the cell itself: own 1, beside 1.1, above 1.2.
    #[test]
    fn a_corner_is_the_mean_of_those_that_meet() {
        let mut tree = Tree::single();
        let [left, _] = tree.split(0, columns::P, 0.0, 1);
        tree.split(left, columns::P + 1, 0.0, 2);
        let models = [(0, 1.0), (1, 1.1), (2, 1.2)].map(|(cell, y)| plain(cell, [y; 3]));
        let field = Field::new(tree, models.to_vec()).unwrap();
        let span = Some(Domain {
            minimum: [-1.0; COUNT],
            maximum: [1.0; COUNT],
        });
        let borders = Borders::new(&field, vec![span; 3]);
        let mut rows = Columns::default();
        rows.push([-1e-7; COUNT]);
        let (mut out, mut cells) = (Default::default(), Vec::new());
        borders
            .evaluate(&field, &rows, &mut out, &mut cells)
            .unwrap();
        assert_eq!(cells, [0]);
        assert!((out[0][0] - 1.1).abs() < 1e-5, "{}", out[0][0]);
    }

    /// Between the two the share falls with the difference: 0.375 apart is half agreed.
    #[test]
    fn agreement_falls_with_the_difference() {
        assert_eq!(agreement([1.0; 3], [1.25; 3]), 1.0);
        let (a, b) = (1.0 - 0.1875, 1.0 + 0.1875);
        assert!((agreement([a; 3], [b; 3]) - 0.5).abs() < 1e-5);
        assert_eq!(agreement([0.5; 3], [1.5; 3]), 0.0);
        assert_eq!(agreement([f32::NAN; 3], [1.0; 3]), 0.0);
    }
}
