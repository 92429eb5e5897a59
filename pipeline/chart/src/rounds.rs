//! `rrf chart RUN`: how a run's error fell, round by round.

use crate::chart::{Joined, Panel, Sheet, files};
use crate::front::{Estimate, Point};
use crate::{ChartError, html};
use rrf_bake::{EvaluatedRound, Run, Timings};
use std::path::{Path, PathBuf};

/// What the vertical axis says.
const ERROR: &str = "error on test rows [%]";

/// What a run had spent after its last round so far.
type Cost = fn(&[Round]) -> Option<f64>;

/// One committed round.
#[derive(Clone, Debug)]
pub struct Round {
    /// Cells, errors and why it was the last, where it was.
    pub evaluated: EvaluatedRound,
    /// What it took; none where nobody wrote it down.
    pub seconds: Option<Timings>,
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

/// A run's committed rounds, the first first.
///
/// # Errors
/// [`ChartError::Bake`] for a damaged file.
pub fn of(run: &Run) -> Result<Vec<Round>, ChartError> {
    let mut rounds = Vec::new();
    while let Some(evaluated) = run.read_evaluated(rounds.len() as u32)? {
        let seconds = run.read_timings(evaluated.round)?;
        rounds.push(Round { evaluated, seconds });
    }
    Ok(rounds)
}

/// Error against the time, rows and weights that a run had after each round.
pub fn panels(runs: &[(String, Vec<Round>)], target: Option<f64>) -> Vec<Panel> {
    let costs: [(&str, Cost); 3] = [
        ("baking so far [s]", seconds),
        ("rows", |so_far| so_far.last().map(|r| r.rows() as f64)),
        ("weights", |so_far| {
            so_far.last().map(|r| r.weights() as f64)
        }),
    ];
    costs
        .map(|(cost, of)| Panel {
            cost,
            error: ERROR,
            points: runs.iter().flat_map(|run| points(run, of)).collect(),
            joined: Joined::Method,
            target,
        })
        .into_iter()
        .filter(|panel| !panel.points.is_empty())
        .collect()
}

/// Time of all rounds so far; none where one's is not known.
fn seconds(so_far: &[Round]) -> Option<f64> {
    let each = so_far.iter().map(|r| r.seconds.map(|s| s.total()));
    each.sum()
}

fn points((name, rounds): &(String, Vec<Round>), cost: Cost) -> Vec<Point> {
    let point = |n: usize| {
        let evaluation = &rounds.get(n)?.evaluated.evaluation;
        let (error, se) = evaluation.error();
        let error = 100.0 * error;
        let cost = cost(rounds.get(..=n)?).filter(|c| *c > 0.0)?;
        (error > 0.0).then(|| Point {
            method: name.clone(),
            setting: format!("round {n}, {} cells", evaluation.cells.len()),
            seeds: 1,
            cost: Estimate {
                mean: cost,
                se: 0.0,
            },
            error: Estimate {
                mean: error,
                se: 100.0 * se,
            },
            on_front: true,
        })
    };
    (0..rounds.len()).filter_map(point).collect()
}

/// A row a round: what it had, what it took, how good it was, what came after.
pub(crate) fn table(rounds: &[Round]) -> String {
    let lines: Vec<Vec<String>> = (rounds.iter())
        .map(|round| {
            let evaluation = &round.evaluated.evaluation;
            let took = |of: fn(Timings) -> f64| {
                round
                    .seconds
                    .map_or("–".into(), |s| format!("{:.1}", of(s)))
            };
            let (error, se) = evaluation.error();
            vec![
                round.evaluated.round.to_string(),
                evaluation.cells.len().to_string(),
                round.rows().to_string(),
                round.weights().to_string(),
                took(|s| s.extract),
                took(|s| s.train),
                took(|s| s.evaluate),
                format!("{:.2} ± {:.2} %", 100.0 * error, 100.0 * se),
                round.evaluated.stop.map_or("another round".into(), |stop| {
                    stop.text(round.evaluated.round + 1)
                }),
            ]
        })
        .collect();
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
    html::table(&heads, &lines)
}

/// Writes `rounds.svg`, `rounds.png` and `rounds.html` of run folders; their paths.
///
/// # Errors
/// [`ChartError::Bake`] for what is no run, [`ChartError::Table`] for runs without a committed
/// round, [`ChartError::Draw`], [`ChartError::File`].
pub fn write(folder: &Path, runs: &[PathBuf]) -> Result<Vec<PathBuf>, ChartError> {
    let (mut all, mut targets, mut below) = (Vec::new(), Vec::new(), String::new());
    for path in runs {
        let run = Run::open(path)?;
        let rounds = of(&run)?;
        if rounds.is_empty() {
            return Err(ChartError::Table {
                path: path.clone(),
                reason: "no round of this run is done: nothing to draw".into(),
            });
        }
        let name = path.file_name().unwrap_or(path.as_os_str());
        let mut name = name.to_string_lossy().into_owned();
        if all.iter().any(|(other, _)| *other == name) {
            name = path.display().to_string();
        }
        below += &format!("<h2>{}</h2>\n{}", html::escape(&name), table(&rounds));
        targets.push(100.0 * f64::from(run.config.target));
        all.push((name, rounds));
    }
    let same = targets.windows(2).all(|pair| pair[0] == pair[1]);
    let target = targets.first().copied().filter(|_| same);
    let panels = panels(&all, target);
    if panels.is_empty() {
        return Err(ChartError::Table {
            path: runs.first().cloned().unwrap_or_default(),
            reason: "no round has an error above zero: nothing to draw".into(),
        });
    }
    let sheet = Sheet {
        name: "rounds",
        title: "Error, round by round",
        about: "<p>Each point is the model after a round of a bake, its bar one standard error: \
                the relative error on test rows, which no net was fitted to, Monte Carlo noise taken out; dashed, the \
                target. Hover for the round, drag to zoom, double-click to zoom out.</p>\n",
        below: &below,
    };
    files(folder, &panels, &sheet)
}
