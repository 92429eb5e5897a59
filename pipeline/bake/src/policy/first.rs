//! The plan of round 0.

use crate::plan::round::{CellPlan, MAX_DRAW_ROWS, RoundPlan, draw_parts};
use crate::policy::test_rows;
use rrf_extract::FirstPlan;
use rrf_train::Size;

/// Plans draws and a fit for every cell of the first tree, and the first test rows.
pub(crate) fn first_round(
    plan: FirstPlan,
    diagonal: f32,
    path_seconds: f64,
    paths: u32,
    size: &Size,
) -> RoundPlan {
    let mut draws = Vec::new();
    let cells = (0u32..).zip(plan.tree.leaves()).zip(&plan.cells);
    let cells = cells.map(|((cell, leaf), share)| CellPlan {
        cell,
        measure: share.measure,
        parts: draw_parts(&mut draws, leaf as u32, share.rows, paths, 0, MAX_DRAW_ROWS),
        size: size.clone(),
        fitted: 0,
        earlier: None,
        prune: None,
    });
    let mut first = RoundPlan {
        round: 0,
        cells: cells.collect(),
        draws,
        tests: Vec::new(),
        tree: plan.tree,
        lambert: plan.lambert,
        mean_radiance: plan.mean_luminance,
        diagonal,
        path_seconds,
        census: plan.census,
        compresses: None,
    };
    test_rows::keep_up(&mut first, paths, 0.0, None);
    first
}

/// A first plan of one cell of 6,000 rows, for tests.
#[cfg(test)]
pub(crate) fn one_cell(paths: u32) -> RoundPlan {
    let first = FirstPlan {
        tree: rrf_field::tree::Tree::single(),
        cells: vec![rrf_extract::CellShare {
            rows: 6000,
            measure: 1.0,
        }],
        lambert: vec![true],
        mean_luminance: 1.0,
        census: rrf_extract::Census::default(),
    };
    first_round(first, 1.0, 1e-6, paths, &Size::Hidden(vec![20, 10]))
}
