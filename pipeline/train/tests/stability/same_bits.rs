//! The same bits again, alone and beside other fits.

use crate::cells::{self, Cell, smooth};
use rrf_train::{CellFit, Size, TrainConfig};

#[test]
fn the_same_bits_on_one_thread_and_on_two() {
    let cells: Vec<Cell> = [500, 700].map(|rows| Cell::new(rows, 0.02, smooth)).into();
    let config = TrainConfig {
        starts: 4,
        rungs: 2,
        ..cells::config()
    };
    let alone: Vec<CellFit> = cells.iter().map(|cell| cell.fit(&config)).collect();
    let together: Vec<CellFit> = std::thread::scope(|scope| {
        let running: Vec<_> = cells
            .iter()
            .map(|cell| scope.spawn(|| cell.fit(&config)))
            .collect();
        running.into_iter().map(|fit| fit.join().unwrap()).collect()
    });
    assert_eq!(alone, together);
}

#[test]
fn the_same_bits_again() {
    let cell = Cell::new(500, 0.02, smooth);
    let config = TrainConfig {
        size: Size::Smallest { target: 0.05 },
        prune: Some(0.02),
        ..cells::config()
    };
    assert_eq!(cell.fit(&config), cell.fit(&config));
}
