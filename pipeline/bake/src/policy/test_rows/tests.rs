use super::*;
use crate::policy::first::one_cell;
use rrf_sampling::{Stage, Stream};

/// A sixteenth of the paths of the samples, at least a few rows, in draws that threads can share.
#[test]
fn in_proportion_to_the_samples() {
    let mut plan = one_cell(128);
    let [samples, tests] = paths_drawn(&plan);
    assert_eq!(samples, 6000.0 * 128.0);
    assert_eq!(
        tests,
        (MIN_ROWS.max((6000.0 * SHARE / 4.0) as u32) * 4 * 128) as f64
    );
    plan.draws[0].rows = 1_000_000;
    keep_up(&mut plan, 128, 0.05, None);
    let [samples, tests] = paths_drawn(&plan);
    assert!((tests / samples / SHARE - 1.0).abs() < 0.001);
    assert!(
        plan.tests
            .iter()
            .all(|p| plan.draws[p.draw as usize].rows <= DRAW)
    );
    assert!((0u32..).zip(&plan.tests).all(|(n, p)| p.part == n));
    let before = plan.clone();
    plan.draws[0].rows = 1_100_000;
    let grown = plan.clone();
    keep_up(&mut plan, 128, 0.05, None);
    assert_eq!(plan, grown, "too few for files of their own");
    plan.draws[0].rows = 2_000_000;
    keep_up(&mut plan, 128, 0.05, Some(&evaluation(0.07, 0.0009)));
    assert_eq!(plan.tests, before.tests, "those that there are tell enough");
    keep_up(&mut plan, 128, 0.05, Some(&evaluation(0.07, 0.0011)));
    assert!(plan.tests.len() > before.tests.len());
}

fn evaluation(relative_error: f64, relative_error_se: f64) -> Evaluation {
    Evaluation {
        relative_error: 0.0,
        relative_error_se: 0.0,
        test: Some(TestError {
            rows: 100,
            relative_error,
            relative_error_se,
        }),
        cells: Vec::new(),
    }
}

/// Twice as many where the target lies within the error's standard error, to a quarter of all.
#[test]
fn more_where_they_cannot_tell() {
    let light_box = rrf_extract::Region {
        minimum: [0.0; 3],
        maximum: [1.0; 3],
    };
    let config = BakeConfig::preset(crate::Preset::Standard, light_box, 1);
    let mut plan = one_cell(128);
    let [samples, mut tests] = paths_drawn(&plan);
    assert!(more(&config, &plan, &evaluation(0.048, 0.001)).is_none());
    assert!(more(&config, &plan, &evaluation(0.06, 0.009)).is_none());
    let mut rounds = 0;
    while let Some(next) = more(&config, &plan, &evaluation(0.048, 0.003)) {
        assert_eq!((next.round, &next.cells), (plan.round + 1, &plan.cells));
        let [same, now] = paths_drawn(&next);
        assert!(same == samples && now > 1.2 * tests);
        (plan, tests, rounds) = (next, now, rounds + 1);
    }
    assert!(rounds > 0 && tests <= MAX_SHARE * samples);
    assert!(2.0 * tests > MAX_SHARE * samples);
}

/// A model a tenth too bright here and too dark there: the error comes out within three of its standard errors
/// and 5 % for what the mixture in the divisor makes of it, however noisy the targets are; and so does one of none.
#[test]
fn noise_does_not_count() {
    let random = Stream::new(7, Stage::Test, 0);
    for (wrong, noise) in [(0.1, 0.2), (0.1, 0.5), (0.0, 0.2)] {
        let row = |i: u64| {
            let m = 2f64.powf(6.0 * random.f64(i, 0) - 3.0);
            let half = |d| m * (1.0 + noise * 12f64.sqrt() * (random.f64(i, d) - 0.5));
            let sign = if random.f64(i, 3) < 0.5 { -1.0 } else { 1.0 };
            TestRow {
                p: [m * (1.0 + sign * wrong); 3],
                halves: [half(1), half(2)].map(|y| [y as f32; 3]),
            }
        };
        let rows: Vec<TestRow> = (0..20_000).map(row).collect();
        let found = error(&rows, 1e-3);
        let square = wrong * wrong;
        let off = (found.square - square).abs();
        assert!(
            off < 3.0 * found.square_se + 0.05 * square,
            "{wrong}, {noise}: {found:?}"
        );
    }
}
