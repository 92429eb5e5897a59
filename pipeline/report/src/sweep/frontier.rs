//! Charts of sweeps: error against time and size, and the settings that nothing beats.

use super::results::SweepRow;
use crate::ReportError;
use crate::chart::{Axis, Chart, Line, Panel, Point, Series};
use crate::html::{or_dash, percent, table};
use maud::{Markup, html};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// One setting over its seeds.
#[derive(Clone, Debug, PartialEq)]
struct Measured {
    method: String,
    setting: String,
    seeds: usize,
    /// Seconds or bytes.
    cost: f64,
    /// Percent.
    error: f64,
    /// Standard error of the error over the seeds; 0 for one seed.
    se: f64,
    /// Nothing else is both cheaper and better.
    on_front: bool,
}

/// A cost of a run; none where it has none.
type Cost = fn(&SweepRow) -> Option<f64>;

/// The panels that a sweep's rows can fill: bake time, frame time, model size.
pub fn frontier_panels(rows: &[SweepRow]) -> Vec<Panel> {
    let costs: [(&str, Cost); 3] = [
        ("CPU time of the bake [s]", |row| row.bake_cpu_seconds),
        ("CPU time of a frame [s]", |row| Some(row.frame_cpu_seconds)),
        ("model [bytes]", |row| row.model_bytes.map(|b| b as f64)),
    ];
    let panels = costs.map(|(title, cost)| (title, measured(rows, cost)));
    let panels = panels.iter().filter(|(_, settings)| !settings.is_empty());
    let all = panels.clone().flat_map(|(_, settings)| settings);
    let methods: BTreeSet<&str> = all.map(|s| s.method.as_str()).collect();
    panels
        .map(|(title, settings)| Panel {
            x: Axis::log(title),
            y: Axis::log("error of the frame's indirect light [%]"),
            series: series(settings, &methods),
        })
        .collect()
}

/// The front, and the settings of each method.
fn series(settings: &[Measured], methods: &BTreeSet<&str>) -> Vec<Series> {
    let front = settings.iter().filter(|s| s.on_front);
    let front = front.map(|s| (s.cost, s.error));
    let name = "nothing is both cheaper and better";
    let mut series = vec![Series::line(Some(name), None, Line::Solid, front)];
    for (color, &method) in methods.iter().enumerate() {
        let mine = settings.iter().filter(|s| s.method == method);
        series.push(Series {
            name: Some(method.into()),
            color: Some(color),
            line: Line::None,
            points: mine.map(Measured::point).collect(),
        });
    }
    series.retain(|series| !series.points.is_empty());
    series
}

impl Measured {
    fn point(&self) -> Point {
        let plural = if self.seeds == 1 { "" } else { "s" };
        Point {
            x: self.cost,
            y: self.error,
            se: self.se,
            radius: if self.on_front { 6 } else { 4 },
            text: format!(
                "{}: {} ({} seed{plural}): error {:.2} ± {:.2} %, cost {:.4}",
                self.method, self.setting, self.seeds, self.error, self.se, self.cost
            ),
        }
    }
}

/// The settings with this cost and an error above zero, ascending in cost.
fn measured(rows: &[SweepRow], cost: Cost) -> Vec<Measured> {
    let mut settings: BTreeMap<(&str, &str), Vec<(f64, f64)>> = BTreeMap::new();
    for row in rows.iter().filter(|row| row.frame_error > 0.0) {
        if let Some(cost) = cost(row).filter(|cost| *cost > 0.0) {
            let key = (row.method.as_str(), row.setting.as_str());
            let runs = settings.entry(key).or_default();
            runs.push((cost, 100.0 * row.frame_error));
        }
    }
    let mut settings: Vec<Measured> = settings
        .into_iter()
        .map(|((method, setting), runs)| {
            let (cost, _) = mean(runs.iter().map(|run| run.0));
            let (error, se) = mean(runs.iter().map(|run| run.1));
            Measured {
                method: method.into(),
                setting: setting.into(),
                seeds: runs.len(),
                cost,
                error,
                se,
                on_front: false,
            }
        })
        .collect();
    settings.sort_by(|a, b| (a.cost.total_cmp(&b.cost)).then(a.error.total_cmp(&b.error)));
    let mut best = f64::INFINITY;
    for setting in &mut settings {
        setting.on_front = setting.error < best;
        best = best.min(setting.error);
    }
    settings
}

/// Mean and its standard error.
fn mean(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let n = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / n;
    let squares: f64 = values.map(|x| (x - mean).powi(2)).sum();
    let variance = if n > 1.0 {
        squares / (n - 1.0) / n
    } else {
        0.0
    };
    (mean, variance.sqrt())
}

/// Writes a sweep's `frontier.svg`, `frontier.png` and `frontier.html`; their paths.
///
/// # Errors
/// [`ReportError::Input`] where there is nothing to draw, [`ReportError::Draw`],
/// [`ReportError::File`].
pub fn write_frontier(
    folder: &Path,
    source: &Path,
    rows: &[SweepRow],
) -> Result<Vec<PathBuf>, ReportError> {
    let panels = frontier_panels(rows);
    if panels.is_empty() {
        let told = "no run in it has an error above zero: nothing to draw";
        return Err(ReportError::input(source, told));
    }
    let about = html! { p {
        "Each point is a setting, its bar one standard error over the seeds. The line joins the \
         settings that no other beats in both. CPU time is that of all cores together; unlike \
         the wall times in the table, it hardly depends on what else the machine does. The error \
         is the relative error of the frame's indirect light against a path-traced reference, \
         whose noise is taken out. Hover for the setting, drag to zoom, double-click to zoom out."
    } };
    let chart = Chart {
        name: "frontier",
        title: "Error against time and size",
        panels: &panels,
        about,
        below: html! { h2 { "Runs" } (runs(rows)) },
    };
    chart.write_files(folder)
}

/// A table with a row a run.
fn runs(rows: &[SweepRow]) -> Markup {
    let heads = [
        "method",
        "setting",
        "seed",
        "bake [CPU s]",
        "bake [s]",
        "frame [CPU s]",
        "frame [s]",
        "model [bytes]",
        "held out",
        "points",
        "frame",
        "FLIP",
        "ΔE2000",
    ];
    let seconds = |s: f64| format!("{s:.1}");
    let row = |r: &SweepRow| {
        vec![
            r.method.clone(),
            r.setting.clone(),
            r.seed.to_string(),
            or_dash(r.bake_cpu_seconds, seconds),
            or_dash(r.bake_seconds, seconds),
            format!("{:.3}", r.frame_cpu_seconds),
            format!("{:.3}", r.frame_seconds),
            or_dash(r.model_bytes, |b| b.to_string()),
            or_dash(r.held_out_error, percent),
            or_dash(r.points_error, percent),
            percent(r.frame_error),
            format!("{:.4}", r.flip),
            format!("{:.2}", r.delta_e_2000),
        ]
    };
    table(&heads, &rows.iter().map(row).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use rrf_sampling::{Stage, Stream};

    fn row(setting: &str, seed: u64, cost: f64, error: f64) -> SweepRow {
        SweepRow {
            method: "cells".into(),
            setting: setting.into(),
            seed,
            bake_seconds: Some(cost),
            frame_error: 0.01 * error,
            ..SweepRow::default()
        }
    }

    fn of(rows: &[SweepRow]) -> Vec<Measured> {
        measured(rows, |r| r.bake_seconds)
    }

    /// Against the definition: on the front is what no other point dominates.
    #[test]
    fn the_front_is_what_nothing_dominates() {
        let random = Stream::new(3, Stage::Test, 0);
        let rows: Vec<SweepRow> = (0..200)
            .map(|i| {
                row(
                    &format!("{i}"),
                    1,
                    1.0 + random.f64(i, 0),
                    1.0 + random.f64(i, 1),
                )
            })
            .collect();
        let found = of(&rows);
        for p in &found {
            let dominated = found.iter().any(|q| {
                let no_worse = q.cost <= p.cost && q.error <= p.error;
                no_worse && (q.cost < p.cost || q.error < p.error)
            });
            assert_eq!(p.on_front, !dominated, "{p:?}");
        }
        assert!((2..100).contains(&found.iter().filter(|p| p.on_front).count()));
    }

    #[test]
    fn seeds_make_error_bars() {
        let rows = [
            row("a", 1, 1.0, 2.0),
            row("a", 2, 3.0, 4.0),
            row("b", 1, 9.0, 9.0),
        ];
        let found = of(&rows);
        assert_eq!((found.len(), found[0].seeds), (2, 2));
        // deviation sqrt(2), over sqrt(2) seeds
        assert!((found[0].se - 1.0).abs() < 1e-12 && (found[0].error - 3.0).abs() < 1e-12);
        assert_eq!(found[1].se, 0.0);
    }

    #[test]
    fn what_has_no_cost_is_left_out() {
        let mut traced = row("spp=4", 1, 0.0, 1.0);
        traced.bake_seconds = None;
        assert!(of(&[traced]).is_empty() && of(&[]).is_empty());
    }
}
