//! The page's tables: settings, cells, scene, and the limits of trust.

use crate::html::{or_dash, percent, percent_se, table};
use maud::{Markup, html};
use rrf_bake::Run;
use rrf_metrics::relative::FORMULA;
use rrf_scene::Scene;
use rrf_store::manifest::RunManifest;
use rrf_store::model::{CellMetrics, Seams, Spread};
use serde_json::Value;

/// Cells that stand open on the page.
const SHOWN: usize = 20;

/// How much the nets are, by name.
pub(super) fn counts(metrics: &[CellMetrics]) -> [(&'static str, String); 3] {
    let weights: u32 = metrics.iter().map(|cell| cell.weights).sum();
    let rows: u64 = metrics.iter().map(|cell| cell.rows).sum();
    [
        ("cells", metrics.len().to_string()),
        ("rows", rows.to_string()),
        ("weights", weights.to_string()),
    ]
}

/// The run's origin, how much its model is, and every setting.
pub(super) fn settings(manifest: &RunManifest, counts: &[(&str, String)]) -> Markup {
    let facts = [
        ("scene", manifest.scene.display().to_string()),
        ("scene's hash (blake3)", manifest.scene_hash.clone()),
        ("baked by", manifest.created_by.clone()),
        ("page by", format!("rrf {}", env!("CARGO_PKG_VERSION"))),
        ("seed", manifest.seed.to_string()),
        (
            "light box [m]",
            manifest.light_box.map(|x| x.to_string()).join(", "),
        ),
    ];
    let facts = facts.iter().chain(counts);
    let facts: Vec<_> = facts
        .map(|(name, value)| vec![name.to_string(), value.clone()])
        .collect();
    let mut settings = Vec::new();
    flatten(&manifest.config, String::new(), &mut settings);
    html! {
        (table(&["what", "value"], &facts))
        details { summary { "Every setting" } (table(&["setting", "value"], &settings)) }
    }
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

/// Limits of what can be trusted.
pub(super) fn caveats(run: &Run, scene: &Scene, metrics: &[CellMetrics]) -> Markup {
    let target = f64::from(run.config.target);
    let missed = |cell: &&CellMetrics| cell.validation.is_none_or(|e| e.relative().0 > target);
    let missed = metrics.iter().filter(missed).count();
    let quarantined: u64 = metrics.iter().map(|cell| cell.quarantined_rows).sum();
    let area_lights = scene.area_lights.len();
    html! {
        h2 { "What is not trusted" }
        ul {
            li {
                (missed) " of " (metrics.len()) " cells miss the target of "
                (format!("{:.1} %", 100.0 * target)) ", or have no rows held out."
            }
            li {
                "Lights outside the light box, and points outside the box that a cell's training \
                 rows span (`trusted` in `rrf query`, the layer `trust` of a frame): the nets \
                 extrapolate."
            }
            li {
                "Lights inside solids, and points sealed under one: left out of training; `rrf \
                 query` says exactly zero there."
            }
            @if quarantined > 0 { li { (quarantined) " rows were left out as impossible." } }
            @if area_lights > 0 {
                li {
                    "The scene's " (area_lights) " area lights are not baked: the nets are for \
                     point lights."
                }
            }
        }
    }
}

/// A row a cell, the worst first.
pub(super) fn cells(metrics: &[CellMetrics]) -> Markup {
    let error = |cell: &CellMetrics| cell.validation.map(|e| e.relative());
    let mut sorted: Vec<&CellMetrics> = metrics.iter().collect();
    let key = |cell: &CellMetrics| error(cell).map_or(f64::INFINITY, |e| e.0);
    sorted.sort_by(|a, b| key(b).total_cmp(&key(a)));
    let seam = |cell: &CellMetrics, of: fn(Seams) -> Option<Spread>| {
        or_dash(cell.seams.and_then(of), |spread| percent(spread.median))
    };
    let row = |cell: &CellMetrics| {
        vec![
            cell.cell_id.to_string(),
            cell.round.to_string(),
            cell.rows.to_string(),
            or_dash(error(cell), percent_se),
            or_dash(cell.train, |e| percent_se(e.relative())),
            or_dash(cell.noise, percent),
            seam(cell, |seams| seams.jump),
            seam(cell, |seams| seams.change),
            cell.weights.to_string(),
            or_dash(cell.effective_parameters, |p| format!("{p:.0}")),
            cell.iterations.to_string(),
            cell.stop_reason.clone(),
        ]
    };
    let rows: Vec<Vec<String>> = sorted.into_iter().map(row).collect();
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
    html! {
        h2 { "Error by cell" }
        p.note {
            "Relative error " (FORMULA) ", Monte Carlo noise taken out, ± its standard error. Worst \
             first. Jump: where the net meets its neighbours', the median relative \
             difference; change: that of the net itself over a tenth of its cell."
        }
        (table(&heads, first))
        @if !rest.is_empty() {
            details { summary { (rest.len()) " more" } (table(&heads, rest)) }
        }
    }
}

/// The scene as it was understood, and what was approximated.
pub(super) fn scene(scene: &Scene) -> Markup {
    let warnings = scene.warnings.iter();
    let warnings = warnings.map(|w| vec![w.place.clone(), w.message.clone()]);
    let warnings: Vec<Vec<String>> = warnings.collect();
    html! {
        h2 { "What was approximated in the import" }
        @if warnings.is_empty() { p { "Nothing." } } @else { (table(&["place", "what"], &warnings)) }
        h2 { "The scene as understood" }
        details { summary { "All of it" } pre { (scene.summary()) } }
    }
}
