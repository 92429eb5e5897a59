use super::*;
use crate::plan::evaluation::CellEvaluation;
use crate::plan::round::CellPlan;

/// Only cells fitted in this round are restored, those that add most first; the rest of the plan stays.
#[test]
fn the_worst_are_restored_first() {
    let of = |squares: [f64; 4]| Evaluation {
        relative_error: 0.0,
        relative_error_se: 0.0,
        test: None,
        cells: (0u32..)
            .zip(squares)
            .map(|(cell, square_error)| CellEvaluation {
                cell,
                measure: [0.1, 0.2, 0.3, 0.4][cell as usize],
                square_error,
                square_error_se: 0.0,
                train_square_error: 0.0,
                noise: 0.0,
                train_rows: 0,
                effective_parameters: 0.0,
                rows: 0,
                weights: 0,
            })
            .collect(),
    };
    let mut before = crate::policy::first::one_cell(128);
    let cell = before.cells[0].clone();
    before.cells = (0..4)
        .map(|id| CellPlan {
            cell: id,
            ..cell.clone()
        })
        .collect();
    let mut plan = before.clone();
    plan.round = 3;
    for cell in &mut plan.cells[..3] {
        (cell.fitted, cell.prune) = (3, Some(0.1));
    }
    // grown by 0.05, 0.04 and 0.03 of the whole's square; the last was not fitted
    let grown = grown(&plan, &of([0.1; 4]), &of([0.6, 0.3, 0.2, 9.0]));
    assert_eq!(grown, [0, 1, 2]);
    let after = restored(&plan, &before, &grown[..2]);
    assert_eq!(after.cells[..2], before.cells[..2]);
    assert_eq!(after.cells[2..], plan.cells[2..]);
    assert_eq!(after.round, 3);
}

/// Cells that lose as much as they may bring the whole to where error and standard error, in
/// proportion, meet the target.
#[test]
fn all_of_the_slack_is_distributed() {
    let evaluation = Evaluation {
        relative_error: 0.04,
        relative_error_se: 0.002,
        test: None,
        cells: Vec::new(),
    };
    let slack = slack(&evaluation, 0.05);
    let (measures, squares) = ([0.25, 0.75], [0.0004, 0.002]);
    let after: f64 = (measures.iter().zip(squares))
        .map(|(m, e)| m * e * (1.0 + share(e, slack).unwrap()).powi(2))
        .sum();
    let before: f64 = measures.iter().zip(squares).map(|(m, e)| m * e).sum();
    let error = (0.04f64.powi(2) + after - before).sqrt();
    assert!((error * (1.0 + 0.002 / 0.04) - 0.05).abs() < 1e-12);
    assert_eq!(share(-1e-5, slack), None);
}
