//! The rows trained on, as they are.

use super::solved::Solved;
use super::weighing::Weighing;
use crate::cell::Cell;
use crate::net::tile::CHANNELS;

/// Their scaled inputs, row after row, then their targets.
pub(super) fn keep(cell: &Cell) -> Vec<Solved> {
    let (inputs, rows) = (cell.units.inputs.len(), cell.train.len());
    let mut weights = Vec::with_capacity((inputs + CHANNELS) * rows);
    let mut values = Vec::with_capacity(CHANNELS * rows);
    Weighing::new(cell).each(|row| {
        weights.extend(row.x.iter().map(|&x| x as f32));
        values.extend(row.target.map(|y| y as f32));
    });
    weights.append(&mut values);
    vec![Solved {
        weights,
        layers: vec![inputs, rows, CHANNELS],
        ridge: 0.0,
    }]
}
