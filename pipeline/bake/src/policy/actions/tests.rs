use super::*;
use crate::Preset;
use crate::policy::first::one_cell;
use rrf_extract::Region;

fn evaluated(noise: f64, gap: f64) -> CellEvaluation {
    CellEvaluation {
        cell: 0,
        measure: 1.0,
        square_error: 0.003 + gap,
        square_error_se: 0.0,
        train_square_error: 0.003,
        noise,
        train_rows: 4200,
        effective_parameters: 300.0,
        rows: 6000,
        weights: 443,
    }
}

/// The number of paths is the best of all powers of two for the time it takes.
#[test]
fn paths_are_the_best_for_their_time() {
    let light_box = Region {
        minimum: [0.0; 3],
        maximum: [1.0; 3],
    };
    let config = BakeConfig::preset(Preset::Standard, light_box, 1);
    for (now, noise, gap) in [(256, 0.2, 0.01), (64, 0.1, 0.02), (128, 0.3, 0.012)] {
        let (plan, evaluated) = (one_cell(now), evaluated(noise, gap));
        let chosen = paths(&config, &plan, &plan.cells[0], &evaluated);
        let size = &plan.cells[0].size;
        let variance = noise * noise * f64::from(now);
        let unexplained = 0.5 * gap * 4200.0 / 300.0 - noise * noise;
        let cost = |paths: u32| {
            let seconds = cost::train_seconds(1_000, size, &config.train, true)
                + cost::draw_seconds(1_000, paths, plan.path_seconds);
            (unexplained + variance / f64::from(paths)) * seconds
        };
        for other in (6..=9).map(|k| 1u32 << k) {
            assert!(cost(chosen) <= cost(other), "{chosen}, {other} is better");
        }
    }
}

#[test]
fn nets_grow_along_the_list_of_architectures() {
    let grown = larger(&Size::Hidden(vec![20, 10]));
    assert_eq!(grown, Some(Size::Hidden(vec![32, 16])));
    assert_eq!(larger(&Size::Hidden(vec![32, 16])), None);
    assert_eq!(larger(&Size::Smallest { target: 0.1 }), None);
}
