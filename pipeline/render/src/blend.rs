//! The nets' light with cells blended where they meet.

use rrf_field::columns::{self, Columns};
use rrf_field::{Borders, FieldError, Lit};

/// [`Lit::evaluate`] with cells blended where they meet.
pub(crate) fn blended(
    borders: &Borders,
    lit: &Lit,
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
