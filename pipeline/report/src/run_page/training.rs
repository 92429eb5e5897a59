//! Training curves, one a cell.

use crate::ReportError;
use crate::chart::{Axis, Line, Panel, Series, chart_svg};
use maud::{Markup, PreEscaped, html};
use rrf_bake::Run;
use rrf_store::layout::fit_folder;
use rrf_store::model::{CellMetrics, FitStep, read_steps};

/// Cells whose curves have a colour and a name.
const NAMED: usize = 5;

/// Error on rows held out and cost on rows trained on, step by step.
pub(super) fn curves(run: &Run, metrics: &[CellMetrics]) -> Result<Markup, ReportError> {
    let facts = run.facts();
    let mut fits = Vec::new();
    for cell in metrics {
        let folder = fit_folder(&run.folder, cell.round, cell.cell_id);
        if let Some(steps) = read_steps(&folder, &facts)?.filter(|steps| !steps.is_empty()) {
            fits.push((cell, steps));
        }
    }
    // the worst come first and have the names
    let error = |cell: &CellMetrics| cell.validation.map_or(0.0, |e| e.mean);
    fits.sort_by(|(a, _), (b, _)| error(b).total_cmp(&error(a)));
    let chart = |title, value: fn(&FitStep) -> Option<f64>| {
        let curve = |(n, (cell, steps)): (usize, &(&CellMetrics, Vec<FitStep>))| {
            let name = (n < NAMED).then(|| format!("cell {}", cell.cell_id));
            let line = if n < NAMED { Line::Solid } else { Line::Pale };
            let step = |s: &FitStep| Some((f64::from(s.step), value(s).filter(|y| *y > 0.0)?));
            let places = steps.iter().filter_map(step);
            Series::line(name.as_deref(), name.is_some().then_some(n), line, places)
        };
        // the best first: the named ones lie on top
        let series = fits.iter().enumerate().rev().map(curve).collect();
        let x = Axis::linear("Levenberg-Marquardt step");
        let y = Axis::log(title);
        chart_svg(&[Panel { x, y, series }])
    };
    let head = html! { h2 { "Training curves" } };
    if fits.is_empty() {
        return Ok(html! { (head) p { "No fit wrote its steps down." } });
    }
    let held_out = chart("error on rows held out [%]", |s| {
        s.relative_square_error.map(|e| 100.0 * e.max(0.0).sqrt())
    })?;
    let cost = chart("cost a residual on rows trained on", |s| s.cost)?;
    Ok(html! {
        (head)
        p.note {
            "A curve a cell, of the fit that is in the model; the " (NAMED.min(fits.len()))
            " worst in colour. Left: relative error on the rows that choose the weights, noise \
             taken out; estimates below zero are left out. Right: mean weighted square residual, \
             noise included; it cannot fall below the noise of the rows."
        }
        figure { (PreEscaped(held_out)) }
        figure { (PreEscaped(cost)) }
    })
}
