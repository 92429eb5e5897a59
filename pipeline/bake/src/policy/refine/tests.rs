use super::*;
use crate::plan::evaluation::TestError;
use crate::policy::first::one_cell;
use crate::policy::tasks::expected_rows;
use rrf_field::columns;
use rrf_train::Size;
use rrf_train::cut::Rule;

/// Each reason to stop at its border, and none beside it.
#[test]
fn stops_where_it_should() {
    let light_box = rrf_extract::Region {
        minimum: [0.0; 3],
        maximum: [1.0; 3],
    };
    let config = BakeConfig {
        target: 0.05,
        rounds: 3,
        ..BakeConfig::preset(crate::Preset::Standard, light_box, 1)
    };
    let after = |round: u32, relative_error: f64, relative_error_se: f64| {
        let plan = RoundPlan {
            round,
            ..one_cell(256)
        };
        let evaluation = Evaluation {
            relative_error,
            relative_error_se,
            test: Some(TestError {
                rows: 1000,
                relative_error,
                relative_error_se,
            }),
            cells: Vec::new(),
        };
        stop_reason(&config, &plan, &evaluation)
    };
    assert_eq!(after(0, 0.048, 0.001), Some(StopReason::Target));
    assert_eq!(after(0, 0.048, 0.003), None);
    // the standard error of a square: twice the error times its own
    assert_eq!(after(0, 0.060, 0.031), Some(StopReason::Noise));
    assert_eq!(after(0, 0.060, 0.029), None);
    // of two errors with squares as well known, the smaller meets what the larger does
    assert_eq!(after(0, 0.048, 0.001), Some(StopReason::Target));
    assert_eq!(after(0, 0.001, 0.048), Some(StopReason::Target));
    assert_eq!(after(1, 0.060, 0.001), None);
    assert_eq!(after(2, 0.060, 0.001), Some(StopReason::Rounds));
    // nothing evaluated is nothing met
    let nothing = Evaluation {
        relative_error: 0.0,
        relative_error_se: 0.0,
        test: None,
        cells: Vec::new(),
    };
    assert!(!nothing.meets(0.05));
    // held-out rows may hide what test rows show
    let evaluation = Evaluation {
        relative_error: 0.060,
        relative_error_se: 0.031,
        test: Some(TestError {
            rows: 1000,
            relative_error: 0.060,
            relative_error_se: 0.010,
        }),
        cells: Vec::new(),
    };
    assert_eq!(stop_reason(&config, &one_cell(256), &evaluation), None);
    // a compression pass is the last round, whatever its error
    let last = RoundPlan {
        compresses: Some(StopReason::Target),
        ..one_cell(256)
    };
    let evaluation = Evaluation {
        relative_error: 0.060,
        relative_error_se: 0.001,
        test: None,
        cells: Vec::new(),
    };
    assert_eq!(
        stop_reason(&config, &last, &evaluation),
        Some(StopReason::Target)
    );
}

fn refinement(action: Action, rows: u32) -> Refinement {
    Refinement {
        cell: 0,
        action,
        share: 1.0,
        left: 0.5,
        seconds: 1.0,
        rows,
        paths: 128,
    }
}

fn cut() -> Cut {
    Cut {
        axis: columns::L,
        threshold: 0.5,
        before: 1.0,
        after: 0.5,
    }
}

/// Children take their parent's rows and are filled up to as many each; a second split does
/// the same to a child, and the plan stays sound.
#[test]
fn children_keep_rows_and_get_the_rest() {
    let mut plan = one_cell(256);
    plan.round = 1;
    apply(
        &mut plan,
        &refinement(
            Action::Split {
                rule: Rule::Logarithm,
                cut: cut(),
                left: 0.3,
            },
            6000,
        ),
        "first".into(),
    );
    plan.check().unwrap();
    assert_eq!(expected_rows(&plan), [6000, 6000]);
    let measures: Vec<f64> = plan.cells.iter().map(|c| c.measure).collect();
    assert_eq!(measures, [0.3, 0.7]);
    assert_eq!(plan.cells[1].parts[0].from, Some([0, 0]));
    let from = |cell: usize| plan.cells[cell].earlier.clone().unwrap();
    assert_eq!(from(0), from(1));
    assert_eq!((from(0).round, from(0).task.as_str()), (0, "first"));
    plan.round = 2;
    apply(
        &mut plan,
        &refinement(Action::MoreRows, 6000),
        "second".into(),
    );
    plan.check().unwrap();
    assert_eq!(expected_rows(&plan), [12_000, 6000]);
    assert_eq!((plan.cells[0].fitted, plan.cells[1].fitted), (2, 1));
    let from = plan.cells[0].earlier.clone().unwrap();
    assert_eq!(
        (from.round, from.cell, from.task.as_str()),
        (1, 0, "second")
    );
    let parts: Vec<u32> = plan.cells[0].parts.iter().map(|p| p.part).collect();
    assert_eq!(parts, [1, 2, 3], "numbers of parts are never used twice");
}

#[test]
fn a_larger_net_draws_nothing() {
    let mut plan = one_cell(256);
    plan.round = 1;
    let draws = plan.draws.clone();
    let size = Size::Hidden(vec![32, 16]);
    apply(
        &mut plan,
        &refinement(Action::LargerNet(size.clone()), 0),
        "first".into(),
    );
    plan.check().unwrap();
    assert_eq!((&plan.draws, &plan.cells[0].size), (&draws, &size));
    assert_eq!(plan.cells[0].fitted, 1);
}

/// A budget takes actions in their order while they fit, and one in any case.
#[test]
fn a_budget_takes_what_fits() {
    let five = vec![refinement(Action::MoreRows, 1); 5];
    let taken = |budget| within(five.clone(), budget).len();
    assert_eq!([None, Some(9.0), Some(5.0)].map(taken), [5; 3]);
    assert_eq!([Some(4.9), Some(1.0)].map(taken), [4, 1]);
    assert_eq!([Some(0.5), Some(0.0), Some(-1.0)].map(taken), [1; 3]);
    assert!(within(Vec::new(), Some(1.0)).is_empty());
}

/// Of each cell what gains most a second, the best cells first, until half of what could be gained
/// is; no more cells than allowed.
#[test]
fn most_gain_a_second_first() {
    let light_box = rrf_extract::Region {
        minimum: [0.0; 3],
        maximum: [1.0; 3],
    };
    let config = |most_cells| BakeConfig {
        target: 0.01,
        most_cells,
        ..BakeConfig::preset(crate::Preset::Standard, light_box, 1)
    };
    let evaluation = Evaluation {
        relative_error: 1.0,
        relative_error_se: 0.0,
        test: None,
        cells: Vec::new(),
    };
    let split = || Action::Split {
        rule: Rule::Logarithm,
        cut: cut(),
        left: 0.5,
    };
    let of = |cell, action, left, seconds| Refinement {
        cell,
        left,
        seconds,
        ..refinement(action, 10)
    };
    let said = [
        of(0, split(), 0.6, 2.0),
        of(0, Action::MoreRows, 0.7, 2.0),
        of(1, split(), 0.5, 1.0),
        of(1, Action::MoreRows, 0.5, 1.0),
        of(2, split(), 0.9, 0.1),
        of(3, Action::MoreRows, 1.1, 0.1),
    ];
    let taken = |most_cells| -> Vec<(u32, bool)> {
        let nothing = GainCalibration::default();
        let taken = chosen(&config(most_cells), &evaluation, &said, &nothing);
        let split = |r: &Refinement| matches!(r.action, Action::Split { .. });
        taken.iter().map(|r| (r.cell, split(r))).collect()
    };
    // gains 0.4, 0.5 and 0.1: half of 1.0 is reached by the two of the best rates a second
    assert_eq!(taken(9), [(2, true), (1, true)]);
    // room for one more cell, which the best takes: the other splits have to wait
    assert_eq!(taken(1), [(2, true)]);
    // room for none
    assert_eq!(taken(0), [(1, false)]);
}
