//! The page's tables: settings, cells, scene.

use crate::html;
use rrf_bake::Run;
use rrf_metrics::relative::FORMULA;
use rrf_scene::Scene;
use rrf_store::model::{CellMetrics, Seams, Spread};
use serde_json::Value;

/// Where the run came from and every setting.
pub(super) fn run(run: &Run, metrics: &[CellMetrics]) -> String {
    let manifest = &run.manifest;
    let weights: u32 = metrics.iter().map(|cell| cell.weights).sum();
    let rows: u64 = metrics.iter().map(|cell| cell.rows).sum();
    let facts = [
        ("scene", manifest.scene.display().to_string()),
        ("scene's hash (blake3)", manifest.scene_hash.clone()),
        ("baked by", manifest.created_by.clone()),
        ("page by", format!("rrf {}", env!("CARGO_PKG_VERSION"))),
        ("seed", manifest.seed.to_string()),
        ("light box [m]", format!("{:?}", manifest.light_box)),
        ("cells", metrics.len().to_string()),
        ("rows", rows.to_string()),
        ("weights", weights.to_string()),
    ];
    let facts: Vec<Vec<String>> = facts.map(|(name, value)| vec![name.into(), value]).into();
    let mut settings = Vec::new();
    flatten(&manifest.config, String::new(), &mut settings);
    format!(
        "{}<details><summary>Every setting</summary>{}</details>\n",
        html::table(&["what", "value"], &facts),
        html::table(&["setting", "value"], &settings)
    )
}

/// `extract.rows`, and its value.
fn flatten(value: &Value, name: String, to: &mut Vec<Vec<String>>) {
    let Value::Object(fields) = value else {
        to.push(vec![name, value.to_string()]);
        return;
    };
    for (field, value) in fields {
        let dot = if name.is_empty() { "" } else { "." };
        flatten(value, format!("{name}{dot}{field}"), to);
    }
}

/// Cells that stand open on the page.
const SHOWN: usize = 20;

/// A row a cell, the worst first.
pub(super) fn cells(metrics: &[CellMetrics]) -> String {
    let error = |cell: &CellMetrics| cell.validation.map(|e| e.relative());
    let mut sorted: Vec<&CellMetrics> = metrics.iter().collect();
    let key = |cell: &CellMetrics| error(cell).map_or(f64::INFINITY, |e| e.0);
    sorted.sort_by(|a, b| key(b).total_cmp(&key(a)));
    let percent = |x: f64| format!("{:.2} %", 100.0 * x);
    let seam = |cell: &CellMetrics, of: fn(Seams) -> Option<Spread>| {
        let median = cell.seams.and_then(of).map(|spread| spread.median);
        median.map_or("–".into(), percent)
    };
    let rows: Vec<Vec<String>> = sorted
        .into_iter()
        .map(|cell| {
            let shown = |e: Option<(f64, f64)>| {
                e.map_or("–".into(), |(e, se)| {
                    format!("{:.2} ± {:.2} %", 100.0 * e, 100.0 * se)
                })
            };
            vec![
                cell.cell_id.to_string(),
                cell.round.to_string(),
                cell.rows.to_string(),
                shown(error(cell)),
                shown(cell.train.map(|e| e.relative())),
                cell.noise.map_or("–".into(), percent),
                seam(cell, |seams| seams.jump),
                seam(cell, |seams| seams.change),
                cell.weights.to_string(),
                cell.effective_parameters
                    .map_or("–".into(), |p| format!("{p:.0}")),
                cell.iterations.to_string(),
                cell.stop_reason.clone(),
            ]
        })
        .collect();
    let (first, rest) = rows.split_at(rows.len().min(SHOWN));
    let heads = [
        "cell",
        "round",
        "rows",
        "held out",
        "train",
        "noise of a row",
        "jump",
        "change",
        "weights",
        "effective",
        "iterations",
        "stopped because",
    ];
    format!(
        "<h2>Error by cell</h2>\n<p class=\"note\">Relative error {FORMULA}, \
         Monte Carlo noise taken out, ± its standard error. Worst \
         first. Jump: where the net meets its neighbours', the median relative difference; \
         change: that of the net itself over a tenth of its cell.</p>\n{}{}",
        html::table(&heads, first),
        match rest.len() {
            0 => String::new(),
            more => format!(
                "<details><summary>{more} more</summary>{}</details>\n",
                html::table(&heads, rest)
            ),
        }
    )
}

/// The scene as it was understood, and what was approximated.
pub(super) fn scene(scene: &Scene) -> String {
    let summary = html::escape(&scene.summary().to_string());
    let warnings: Vec<Vec<String>> = (scene.warnings.iter())
        .map(|w| vec![w.place.clone(), w.message.clone()])
        .collect();
    let approximated = if warnings.is_empty() {
        "<p>Nothing.</p>\n".to_string()
    } else {
        html::table(&["place", "what"], &warnings)
    };
    format!(
        "<h2>What was approximated in the import</h2>\n{approximated}\
         <h2>The scene as understood</h2>\n<details><summary>All of it</summary>\
         <pre>{summary}</pre></details>\n"
    )
}
