//! Named sets of options.

use rrf_lm::{LmConfig, Scaling};
use rrf_train::{Batches, Decay, Schedule, Size, TrainConfig};

fn lm(change: impl Fn(&mut LmConfig)) -> TrainConfig {
    let mut config = TrainConfig::default();
    change(&mut config.lm);
    config
}

fn with(change: impl Fn(&mut TrainConfig)) -> TrainConfig {
    let mut config = TrainConfig::default();
    change(&mut config);
    config
}

fn online(rows: usize, steps: usize) -> TrainConfig {
    with(|c| c.mode = Schedule::Online(Batches { rows, steps }))
}

fn recursive(rows: usize, steps: usize) -> TrainConfig {
    with(|c| c.mode = Schedule::Recursive(Batches { rows, steps }))
}

/// Everything that the documentation's tables compare.
pub fn all() -> Vec<(&'static str, TrainConfig)> {
    vec![
        ("default", TrainConfig::default()),
        ("steps-30", with(|c| c.iterations = 30)),
        ("steps-120", with(|c| c.iterations = 120)),
        ("patience-3", with(|c| c.patience = 3)),
        ("patience-12", with(|c| c.patience = 12)),
        ("scaling-more", lm(|c| c.scaling = Scaling::More)),
        (
            "scaling-clamped-1e-6",
            lm(|c| c.scaling = Scaling::Clamped { floor: 1e-6 }),
        ),
        (
            "scaling-clamped-1e-3",
            lm(|c| c.scaling = Scaling::Clamped { floor: 1e-3 }),
        ),
        ("scaling-marquardt", lm(|c| c.scaling = Scaling::Marquardt)),
        ("acceleration", lm(|c| c.acceleration = 0.75)),
        ("tau-1e-2", lm(|c| c.tau = 1e-2)),
        ("tau-1e-5", lm(|c| c.tau = 1e-5)),
        ("decay-none", with(|c| c.decay = Decay::Fixed(0.0))),
        ("decay-1e-6", with(|c| c.decay = Decay::Fixed(1e-6))),
        ("decay-1e-4", with(|c| c.decay = Decay::Fixed(1e-4))),
        ("rungs-0", with(|c| c.rungs = 0)),
        ("rungs-1", with(|c| c.rungs = 1)),
        (
            "rungs-3-steps-10",
            with(|c| (c.rungs, c.rung_steps) = (3, 10)),
        ),
        ("starts-2-rungs-2", with(|c| (c.starts, c.rungs) = (2, 2))),
        ("starts-4-rungs-3", with(|c| (c.starts, c.rungs) = (4, 3))),
        ("starts-8-rungs-3", with(|c| (c.starts, c.rungs) = (8, 3))),
        ("starts-4-rungs-0", with(|c| (c.starts, c.rungs) = (4, 0))),
        ("absolute", with(|c| c.relative = false)),
        ("net-8-4", with(|c| c.size = Size::Hidden(vec![8, 4]))),
        ("net-12-8", with(|c| c.size = Size::Hidden(vec![12, 8]))),
        ("net-32-16", with(|c| c.size = Size::Hidden(vec![32, 16]))),
        (
            "smallest-20",
            with(|c| c.size = Size::Smallest { target: 0.20 }),
        ),
        (
            "smallest-10",
            with(|c| c.size = Size::Smallest { target: 0.10 }),
        ),
        (
            "smallest-5",
            with(|c| c.size = Size::Smallest { target: 0.05 }),
        ),
        ("prune-5", with(|c| c.prune = Some(0.05))),
        (
            "smallest-10-prune",
            with(|c| (c.size, c.prune) = (Size::Smallest { target: 0.10 }, Some(0.02))),
        ),
        ("mode-online-512-1", online(512, 1)),
        ("mode-online-512-10", online(512, 10)),
        ("mode-recursive-512-1", recursive(512, 1)),
        ("mode-recursive-512-3", recursive(512, 3)),
        ("mode-recursive-512-10", recursive(512, 10)),
    ]
}
