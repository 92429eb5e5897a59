//! The nets' light with cells blended where they meet.

use rrf_field::columns::{self, Columns};
use rrf_field::{Borders, FieldError, LitField};

/// [`LitField::evaluate`] with cells blended where they meet.
pub(crate) fn evaluate_blended(
    borders: &Borders,
    lit: &LitField,
    rows: &Columns,
    sum: &mut [Vec<f32>; 3],
    cells: &mut Vec<u32>,
) -> Result<(), FieldError> {
    let (mut rows, mut out, mut under) = (rows.clone(), Default::default(), Vec::new());
    cells.clear();
    cells.resize(rows.len(), u32::MAX);
    for channel in sum.iter_mut() {
        channel.clear();
        channel.resize(rows.len(), 0.0);
    }
    for (k, light) in lit.lights().iter().enumerate() {
        for (i, x) in light.position.into_iter().enumerate() {
            rows.columns[columns::L + i].fill(x);
        }
        borders.evaluate(lit.field(), &rows, &mut out, &mut under)?;
        for ((sum, out), intensity) in sum.iter_mut().zip(&out).zip(light.intensity) {
            sum.iter_mut()
                .zip(out)
                .for_each(|(sum, y)| *sum += intensity * y);
        }
        if k == 0 {
            cells.clone_from(&under);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use rrf_field::model::{CellModel, Kind};
    use rrf_field::net::Shape;
    use rrf_field::tree::{Domain, Tree};
    use rrf_field::{Field, Light};

    fn plain(cell: u32, y: f32) -> CellModel {
        CellModel {
            cell,
            kind: Kind::Net,
            inputs: Vec::new(),
            input_offset: Vec::new(),
            input_scale: Vec::new(),
            shape: Shape { sizes: vec![0, 3] },
            weights: vec![0.0; 3],
            output_scale: [1.0; 3],
            output_offset: [y; 3],
            divide_base: false,
            exponential: false,
        }
    }

    /// Two cells that part the lights at x = 0, with spans of 2 and 1: a light at -0.05 is a fortieth of its cell
    /// from the other, which has a share of 3/8 there; one at 0.5 has no neighbour.
    #[test]
    fn lights_add_up_each_blended_by_its_own_place() {
        let mut tree = Tree::single();
        tree.split(0, columns::L, 0.0, 1);
        let field = Field::new(tree, vec![plain(0, 1.0), plain(1, 1.2)]).unwrap();
        let span = |low: f32, high: f32| {
            let mut span = Domain {
                minimum: [0.5; columns::COUNT],
                maximum: [0.5; columns::COUNT],
            };
            (span.minimum[columns::L], span.maximum[columns::L]) = (low, high);
            Some(span)
        };
        let borders = Borders::new(&field, vec![span(-2.0, 0.0), span(0.0, 1.0)]);
        let light = |x: f32, intensity: [f32; 3]| Light {
            position: [x, 0.5, 0.5],
            intensity,
        };
        let lit = field.under(&[light(-0.05, [2.0, 3.0, 0.0]), light(0.5, [1.0, 0.0, 4.0])]);
        let mut rows = Columns::default();
        rows.push([0.5; columns::COUNT]);
        let (mut out, mut cells) = (Default::default(), Vec::new());
        evaluate_blended(&borders, &lit, &rows, &mut out, &mut cells).unwrap();
        let near = 1.0 + 0.375 * 0.2;
        let expected = [2.0 * near + 1.2, 3.0 * near, 4.0 * 1.2];
        for (found, expected) in out.iter().zip(expected) {
            assert!((found[0] - expected).abs() < 1e-5, "{found:?} {expected}");
        }
        assert_eq!(cells, [0]);
    }
}
