//! Choice of a cell of a picture by weight.

/// A choice among the cells of a picture, with probabilities proportional to weights: a row by
/// the rows' sums, then a column. By inversion, so that stratified numbers stay stratified.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CellChoice {
    width: u32,
    /// Cumulative probability of the rows, one entry a row.
    rows: Vec<f64>,
    /// Cumulative probability of the columns within their row, one entry a cell.
    columns: Vec<f32>,
}

/// A cell, and a place within it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cell {
    pub(crate) column: u32,
    pub(crate) row: u32,
    /// Place across and down the cell, in [0, 1), uniform.
    pub(crate) place: [f32; 2],
    pub(crate) probability: f32,
}

impl CellChoice {
    /// `weights(column, row)` are finite and not negative; `None` where all are zero.
    pub(crate) fn new(
        width: u32,
        height: u32,
        weights: impl Fn(u32, u32) -> f64,
    ) -> Option<CellChoice> {
        let mut rows = Vec::with_capacity(height as usize);
        let mut columns = Vec::with_capacity(width as usize * height as usize);
        let (mut total, mut row) = (0.0, Vec::with_capacity(width as usize));
        for y in 0..height {
            row.clear();
            let mut sum = 0.0;
            row.extend((0..width).map(|x| {
                sum += weights(x, y);
                sum
            }));
            columns.extend(row.iter().map(|c| (c / sum.max(f64::MIN_POSITIVE)) as f32));
            total += sum;
            rows.push(total);
        }
        rows.iter_mut().for_each(|sum| *sum /= total);
        (total > 0.0 && total.is_finite()).then_some(CellChoice {
            width,
            rows,
            columns,
        })
    }

    fn row(&self, row: u32) -> &[f32] {
        let (first, width) = (row as usize * self.width as usize, self.width as usize);
        self.columns.get(first..first + width).unwrap_or_default()
    }

    /// Probability of a cell.
    pub(crate) fn probability(&self, column: u32, row: u32) -> f32 {
        let of_row = step(&self.rows, row as usize) as f32;
        of_row * step(self.row(row), column as usize)
    }

    /// A cell by two numbers in [0, 1), the first for the row.
    pub(crate) fn sample(&self, u: [f32; 2]) -> Cell {
        let (row, down) = choose(&self.rows, f64::from(u[0]));
        let columns = self.row(row as u32);
        let (column, across) = choose(columns, u[1]);
        Cell {
            column: column as u32,
            row: row as u32,
            place: [across, down as f32].map(|x| x.min(1.0f32.next_down())),
            probability: step(&self.rows, row) as f32 * step(columns, column),
        }
    }
}

/// The probability between an entry of a cumulative column and the one before it.
fn step<T: Copy + Default + std::ops::Sub<Output = T>>(cumulative: &[T], at: usize) -> T {
    let upto = |at: Option<usize>| at.and_then(|at| cumulative.get(at)).copied();
    upto(Some(at)).unwrap_or_default() - upto(at.checked_sub(1)).unwrap_or_default()
}

/// The entry that `u` falls into, and how far into it.
fn choose<T>(cumulative: &[T], u: T) -> (usize, T)
where
    T: Copy + Default + PartialOrd + std::ops::Sub<Output = T> + std::ops::Div<Output = T>,
{
    let end = cumulative.last().copied().unwrap_or_default();
    let last = cumulative.partition_point(|&c| c < end);
    let at = cumulative.partition_point(|&c| c <= u).min(last);
    let before = at.checked_sub(1).and_then(|at| cumulative.get(at));
    let into = u - before.copied().unwrap_or_default();
    (at, into / step(cumulative, at))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every cell is met as often as its probability says, empty ones never.
    #[test]
    fn cells_have_their_weights() {
        let weights = [[0.0, 1.0, 3.0], [0.0, 0.0, 0.0], [2.0, 0.0, 2.0]];
        let choice = CellChoice::new(3, 3, |x, y| weights[y as usize][x as usize]).unwrap();
        const STEPS: u32 = 512;
        let mut counts = [[0u32; 3]; 3];
        for i in 0..STEPS * STEPS {
            let u = [i / STEPS, i % STEPS].map(|k| (k as f32 + 0.5) / STEPS as f32);
            let cell = choice.sample(u);
            assert_eq!(cell.probability, choice.probability(cell.column, cell.row));
            assert!(
                cell.place.iter().all(|p| (0.0..1.0).contains(p)),
                "{cell:?}"
            );
            counts[cell.row as usize][cell.column as usize] += 1;
        }
        for (row, weights) in counts.iter().zip(weights) {
            for (&count, weight) in row.iter().zip(weights) {
                let share = f64::from(count) / f64::from(STEPS * STEPS);
                // A border lies within a step of its place in either dimension.
                assert!((share - weight / 8.0).abs() < 4.0 / f64::from(STEPS));
                assert!(weight > 0.0 || count == 0);
            }
        }
    }

    #[test]
    fn the_largest_number_stays_inside() {
        let choice = CellChoice::new(2, 2, |x, y| f64::from(u8::from(x == 0 && y == 0))).unwrap();
        let cell = choice.sample([1.0f32.next_down(); 2]);
        assert_eq!((cell.column, cell.row, cell.probability), (0, 0, 1.0));
        assert!(CellChoice::new(2, 2, |_, _| 0.0).is_none());
    }
}
