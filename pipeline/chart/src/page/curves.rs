//! How the fits went: a curve a cell.

use crate::draw::{Curve, Curves, svg_curves};
use crate::{ChartError, html};
use rrf_bake::Run;
use rrf_store::layout::fit_folder;
use rrf_store::model::{CellMetrics, FitStep, read_steps};

/// Cells whose curves have a colour and a name.
const NAMED: usize = 5;

/// Error on rows held out and cost on rows trained on, step by step.
pub(super) fn training(run: &Run, metrics: &[CellMetrics]) -> Result<String, ChartError> {
    let facts = run.facts();
    let mut fits = Vec::new();
    for cell in metrics {
        let folder = fit_folder(&run.folder, cell.round, cell.cell_id);
        if let Some(steps) = read_steps(&folder, &facts)?.filter(|steps| !steps.is_empty()) {
            fits.push((cell, steps));
        }
    }
    let head = "<h2>Training curves</h2>\n";
    if fits.is_empty() {
        return Ok(format!("{head}<p>No fit wrote its steps down.</p>\n"));
    }
    // the worst come first and have the names
    let error = |cell: &CellMetrics| cell.validation.map_or(0.0, |e| e.mean);
    fits.sort_by(|(a, _), (b, _)| error(b).total_cmp(&error(a)));
    let curves = |y, value: fn(&FitStep) -> Option<f64>| {
        let of = |(n, (cell, steps)): (usize, &(&CellMetrics, Vec<FitStep>))| Curve {
            name: (n < NAMED).then(|| format!("cell {}", cell.cell_id)),
            points: (steps.iter())
                .filter_map(|s| Some((f64::from(s.step), value(s)?)))
                .collect(),
        };
        svg_curves(&Curves {
            x: "Levenberg-Marquardt step",
            y,
            curves: fits.iter().enumerate().map(of).collect(),
        })
    };
    let held_out = curves("error on rows held out [%]", |s| {
        s.relative_square_error.map(|e| 100.0 * e.max(0.0).sqrt())
    })?;
    let cost = curves("cost a residual on rows trained on", |s| s.cost)?;
    let note = html::escape(&format!(
        "A curve a cell, of the fit that is in the model; the {} worst in colour. Left: relative \
         error on the rows that choose the weights, noise taken out; estimates below zero \
         are left out. Right: mean weighted square residual, noise included: it cannot fall below the \
         noise of the rows.",
        NAMED.min(fits.len())
    ));
    Ok(format!(
        "{head}<p class=\"note\">{note}</p>\n<figure>{held_out}</figure><figure>{cost}</figure>\n"
    ))
}
