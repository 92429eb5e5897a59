use super::*;
use crate::plan::round::EarlierFit;
use crate::policy::first::one_cell;
use rrf_train::Size;
use rrf_train::cut::{Cut, Rule};

fn refinement(cell: u32, action: Action, left: f64) -> Refinement {
    Refinement {
        cell,
        action,
        share: 1.0,
        left,
        seconds: 1.0,
        rows: 1,
        paths: 64,
    }
}

fn evaluated(cell: u32, square_error: f64) -> CellEvaluation {
    CellEvaluation {
        cell,
        measure: 0.25,
        square_error,
        square_error_se: 0.0,
        train_square_error: 0.0,
        noise: 0.0,
        train_rows: 100,
        effective_parameters: 1.0,
        rows: 100,
        weights: 1,
    }
}

/// Cell 0 became 0 and 3, cell 1 got more rows, cell 2 a larger net: each is compared with what
/// was predicted for it, and with nothing else; cells that were left alone do not count.
#[test]
fn compares_the_measured_with_the_predicted_error() {
    let mut plan = one_cell(64);
    plan.round = 1;
    let cell = |id: u32, from: u32, size: &[usize]| CellPlan {
        cell: id,
        fitted: 1,
        size: Size::Hidden(size.to_vec()),
        earlier: Some(EarlierFit {
            round: 0,
            cell: from,
            task: String::new(),
        }),
        ..one_cell(64).cells[0].clone()
    };
    let small: &[usize] = &[20, 10];
    plan.cells = vec![
        cell(0, 0, small),
        cell(1, 1, small),
        cell(2, 2, &[32, 16]),
        cell(3, 0, small),
        CellPlan {
            fitted: 0,
            ..cell(4, 4, small)
        },
    ];
    for (from, axis, new) in [(0, 0, 1), (1, 0, 2), (0, 1, 3), (2, 0, 4)] {
        let leaf = plan.tree.leaves()[from];
        plan.tree.split(leaf, axis, 0.25, new);
    }
    let split = |rule| Action::Split {
        rule,
        cut: Cut {
            axis: if rule == Rule::Logarithm { 1 } else { 5 },
            threshold: 0.25,
            before: 1.0,
            after: 0.5,
        },
        left: 0.5,
    };
    let grow = || Action::LargerNet(Size::Hidden(vec![32, 16]));
    let predicted: Vec<Refinement> = (0..5)
        .flat_map(|c| {
            let splits = [Rule::Logarithm, Rule::Relative].map(|rule| (split(rule), 0.7));
            let each = [(Action::MoreRows, 0.6), (grow(), 0.9)];
            let each = [splits, each].concat();
            each.into_iter()
                .map(move |(action, left)| refinement(c, action, left))
        })
        .collect();
    // in any order: a cell without rows to evaluate it is not among them
    let after = [(4, 9.0), (2, 4.0), (0, 0.8), (1, 2.0), (3, 1.2)];
    let after = after.map(|(c, e)| evaluated(c, e));
    let mut all = GainCalibration::default();
    all.add(&plan, &predicted, &after);
    let of_rule = |rule| all.sums.get(&RefinementKind::Split(rule));
    assert_eq!(
        of_rule(Rule::Logarithm),
        Some(&[0.7, 0.25 * 0.8 + 0.25 * 1.2])
    );
    assert_eq!(of_rule(Rule::Relative), None, "another cut than was made");
    assert_eq!(all.sums[&RefinementKind::MoreRows], [0.6, 0.5]);
    assert_eq!(all.sums[&RefinementKind::LargerNet], [0.9, 1.0]);
    let left = all.left(&refinement(9, Action::MoreRows, 0.3));
    assert!((left - 0.3 * 0.5 / 0.6).abs() < 1e-12, "{left}");
    // before anything is measured, as predicted
    assert_eq!(GainCalibration::default().left(&predicted[0]), 0.7);
    all.mean = 1e6;
    assert!((all.left(&predicted[0]) - 0.7).abs() < 1e-5);
}
