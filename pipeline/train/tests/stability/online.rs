//! Batches in adversarial order: one light a batch, the light far from the last one's.
//!
//! Trained one after another to convergence, as an earlier system did it, each batch wipes out
//! what the last one taught. The recursive mode remembers.

use crate::cells::{self, Cell, Row, smooth};
use rrf_sampling::{Stage, Stream};
use rrf_train::{Batches, Schedule, TrainConfig};

const LIGHTS: usize = 24;
const A_LIGHT: usize = 150;

/// The rows of one light after the other's; held-out rows of all lights.
fn one_light_a_batch() -> Cell {
    let stream = Stream::new(4, Stage::Test, 5);
    let rows: Vec<Row> = (0..LIGHTS * A_LIGHT)
        .map(|i| {
            let light = |d: u32| 2.0 * stream.f64((i / A_LIGHT) as u64, 20 + d) - 1.0;
            let mut row: Row = std::array::from_fn(|d| 2.0 * stream.f64(i as u64, d as u32) - 1.0);
            (row[5], row[6], row[7]) = (light(0), light(1), light(2));
            row
        })
        .collect();
    Cell::of(&rows, 0.0, smooth)
}

/// The relative error on all lights at the end of the last batch.
fn last_error(mode: Schedule) -> f64 {
    let config = TrainConfig {
        mode,
        ..cells::config()
    };
    let fit = one_light_a_batch().fit(&config);
    fit.history.last().unwrap().validation.max(0.0).sqrt()
}

#[test]
fn online_forgets_and_recursive_remembers() {
    // two of three rows of each light are trained on
    let batches = Batches {
        rows: A_LIGHT * 2 / 3,
        steps: 30,
    };
    let online = last_error(Schedule::Online(batches));
    let recursive = last_error(Schedule::Recursive(batches));
    let local = one_light_a_batch().fit(&cells::config());
    let local = local.validation_error.relative();
    println!("local {local}, recursive {recursive}, online {online}");
    assert!(online > 5.0 * local, "online {online}, local {local}");
    assert!(
        recursive < 0.25 * online,
        "recursive {recursive}, online {online}"
    );
}
