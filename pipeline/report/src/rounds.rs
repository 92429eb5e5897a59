//! A run's error, round by round.

use crate::ReportError;
use crate::chart::{Axis, Chart, Line, Panel, Point, Series};
use crate::html::{or_dash, percent_se, table};
use maud::{Markup, html};
use rrf_bake::{EvaluatedRound, Run, RunMethod, Timings};
use std::path::{Path, PathBuf};

/// Cost of a run's rounds so far; none where it is not known.
type CostSoFar = fn(&[Round]) -> Option<f64>;

/// One committed round.
#[derive(Clone, Debug)]
pub(crate) struct Round {
    /// Cells, errors and why it was the last, where it was.
    evaluated: EvaluatedRound,
    /// Times of its stages; none where nobody wrote them down.
    seconds: Option<Timings>,
}

impl Round {
    fn rows(&self) -> u64 {
        self.evaluated.evaluation.cells.iter().map(|c| c.rows).sum()
    }

    fn weights(&self) -> u64 {
        let cells = self.evaluated.evaluation.cells.iter();
        cells.map(|c| u64::from(c.weights)).sum()
    }
}

/// Reads a run's committed rounds, the first first.
///
/// # Errors
/// [`ReportError::Bake`] for a damaged file.
pub(crate) fn read_rounds(run: &Run) -> Result<Vec<Round>, ReportError> {
    let mut rounds = Vec::new();
    while let Some(evaluated) = run.read_evaluated(rounds.len() as u32)? {
        let seconds = run.read_timings(evaluated.round)?;
        rounds.push(Round { evaluated, seconds });
    }
    Ok(rounds)
}

/// Error against the time, rows and weights that each run had after each round; `target` in
/// percent.
pub(crate) fn round_panels(runs: &[(String, Vec<Round>)], target: Option<f64>) -> Vec<Panel> {
    let costs: [(&str, CostSoFar); 3] = [
        ("baking so far [s]", |rounds| {
            rounds.iter().map(|r| r.seconds.map(|s| s.total())).sum()
        }),
        ("rows", |rounds| Some(rounds.last()?.rows() as f64)),
        ("weights", |rounds| Some(rounds.last()?.weights() as f64)),
    ];
    let panel = |(title, cost): (&'static str, CostSoFar)| {
        let mut series = Vec::new();
        for (number, (name, rounds)) in runs.iter().enumerate() {
            let point = |n: usize| point(name, rounds, n, cost);
            series.push(Series {
                name: Some(name.clone()),
                color: Some(number),
                line: Line::Solid,
                points: (0..rounds.len()).filter_map(point).collect(),
            });
        }
        series.retain(|series| !series.points.is_empty());
        let costs = || series.iter().flat_map(|s| &s.points).map(|p| p.x);
        let ends = [
            costs().fold(f64::INFINITY, f64::min),
            costs().fold(0.0, f64::max),
        ];
        if let Some(target) = target.filter(|_| !series.is_empty()) {
            let level = ends.map(|x| (x, target));
            series.insert(0, Series::line(Some("target"), None, Line::Dashed, level));
        }
        Panel {
            x: Axis::log(title),
            y: Axis::log("error on test rows [%]"),
            series,
        }
    };
    let mut panels = costs.map(panel).to_vec();
    panels.retain(|panel| !panel.series.is_empty());
    panels
}

/// The model after round `n`.
fn point(name: &str, rounds: &[Round], n: usize, cost: CostSoFar) -> Option<Point> {
    let evaluation = &rounds.get(n)?.evaluated.evaluation;
    let (error, se) = evaluation.error();
    let cost = cost(rounds.get(..=n)?).filter(|cost| *cost > 0.0)?;
    (error > 0.0).then(|| Point {
        x: cost,
        y: 100.0 * error,
        se: 100.0 * se,
        radius: 6,
        text: format!(
            "{name}: round {n}, {} cells: error {}, cost {cost:.4}",
            evaluation.cells.len(),
            percent_se((error, se))
        ),
    })
}

/// A table with a row a round: size, time, error, and what came after.
pub(crate) fn rounds_table(rounds: &[Round]) -> Markup {
    let row = |round: &Round| {
        let evaluation = &round.evaluated.evaluation;
        let took = |of: fn(Timings) -> f64| or_dash(round.seconds, |s| format!("{:.1}", of(s)));
        vec![
            round.evaluated.round.to_string(),
            evaluation.cells.len().to_string(),
            round.rows().to_string(),
            round.weights().to_string(),
            took(|s| s.extract),
            took(|s| s.train),
            took(|s| s.evaluate),
            percent_se(evaluation.error()),
            match round.evaluated.stop {
                Some(stop) => stop.text(round.evaluated.round + 1),
                None => "another round".into(),
            },
        ]
    };
    let heads = [
        "round",
        "cells",
        "rows",
        "weights",
        "extraction [s]",
        "training [s]",
        "judging [s]",
        "error on test rows",
        "and then",
    ];
    table(&heads, &rounds.iter().map(row).collect::<Vec<_>>())
}

/// Writes `rounds.svg`, `rounds.png` and `rounds.html` of run folders; their paths.
///
/// # Errors
/// [`ReportError::Bake`] for what is no run, [`ReportError::Input`] for runs without a committed
/// round, [`ReportError::Draw`], [`ReportError::File`].
pub(crate) fn write_rounds(folder: &Path, runs: &[PathBuf]) -> Result<Vec<PathBuf>, ReportError> {
    let (mut all, mut targets) = (Vec::new(), Vec::new());
    for path in runs {
        if RunMethod::of(path)? == RunMethod::Transfer {
            let told = "is a run of a transfer, which has no rounds to draw. `rrf report` shows its errors, and \
                        `rrf sweep` and then `rrf chart` draw its error against time";
            return Err(ReportError::input(path, told));
        }
        let run = Run::open(path)?;
        let rounds = read_rounds(&run)?;
        if rounds.is_empty() {
            let told = "no round of this run is done: nothing to draw";
            return Err(ReportError::input(path, told));
        }
        let name = path.file_name().unwrap_or(path.as_os_str());
        let mut name = name.to_string_lossy().into_owned();
        if all.iter().any(|(other, _)| *other == name) {
            name = path.display().to_string();
        }
        targets.push(100.0 * f64::from(run.config.target));
        all.push((name, rounds));
    }
    targets.dedup();
    let panels = round_panels(
        &all,
        targets.first().copied().filter(|_| targets.len() == 1),
    );
    if panels.is_empty() {
        let told = "no round has an error above zero: nothing to draw";
        return Err(ReportError::input(&runs[0], told));
    }
    let about = html! { p {
        "Each point is the model after a round of a bake, its bar one standard error: the \
         relative error on test rows, which no net was fitted to, Monte Carlo noise taken out. \
         The dashed line is the target. Hover for the round, drag to zoom, double-click to zoom \
         out."
    } };
    let below = html! {
        @for (name, rounds) in &all { h2 { (name) } (rounds_table(rounds)) }
    };
    let chart = Chart {
        name: "rounds",
        title: "Error, round by round",
        panels: &panels,
        about,
        below,
    };
    chart.write_files(folder)
}
