//! The page of a transfer's run.

use super::frames::{FrameOptions, Pictured, frames};
use super::tables;
use crate::html::{or_dash, percent, percent_se, table};
use crate::{Program, ReportError};
use maud::{Markup, html};
use rrf_bake::{TransferRun, TransferSummary};
use rrf_metrics::relative::FORMULA;
use rrf_scene::Scene;
use rrf_store::model::read_transfer;
use std::path::Path;

/// Cells that stand open on the page.
const SHOWN: usize = 20;

/// All about the run.
pub(super) fn page(
    folder: &Path,
    frame: &FrameOptions,
    program: &Program,
) -> Result<Markup, ReportError> {
    let run = TransferRun::open(folder)?;
    let scene = run.load_scene()?;
    let summary = run.summary(&scene.unlit())?;
    let counts = [
        ("method", "transfer".to_string()),
        ("patches", summary.patches.to_string()),
        ("columns", summary.columns.to_string()),
        ("lights", summary.lights.to_string()),
        ("cells", summary.cells.to_string()),
        ("cells with nets", summary.nets.to_string()),
        ("rows", summary.rows.to_string()),
    ];
    let pictured = Pictured {
        run: folder,
        manifest: &run.manifest,
        read_by: run.config.load_options(),
        shows_own_lights: scene.has_own_lights(),
        model: "transfer",
    };
    Ok(html! {
        (tables::settings(&run.manifest, &counts))
        (errors(&summary, f64::from(run.config.target)))
        (caveats(&summary, &scene))
        (frames(frame, program, &pictured)?)
        (cells(&run)?)
        (tables::scene(&scene))
    })
}

/// The error on test rows, and by trust.
fn errors(summary: &TransferSummary, target: f64) -> Markup {
    let test = &summary.test;
    let error = percent_se((test.relative_error, test.relative_error_se));
    let held_out = percent_se((summary.held_out_error, summary.held_out_error_se));
    let rows = [
        ("target", percent(target)),
        ("error on test rows", error),
        ("median of the rows", percent(test.median_error)),
        ("95th percentile", percent(test.percentile_95)),
        (
            "share of the squared error in the worst 1 %",
            percent(test.worst_share),
        ),
        ("trusted rows", percent(test.trusted_share)),
        ("error of trusted rows", percent(test.trusted_error)),
        ("error on held-out rows", held_out),
    ];
    let rows = rows.map(|(name, value)| vec![name.to_string(), value]);
    html! {
        h2 { "Error" }
        p.note {
            "Relative error " (FORMULA) ", Monte Carlo noise removed. " (test.test_rows) " test rows: places that eyes see, \
             under lights that the ensemble does not hold and the scene's own, against the path tracer. Held-out rows lie \
             where light falls steeply, and each cell's own error has one standard error added."
        }
        (table(&["what", "value"], &rows))
    }
}

/// Limits of what can be trusted.
fn caveats(summary: &TransferSummary, scene: &Scene) -> Markup {
    html! {
        h2 { "What is not trusted" }
        ul {
            li { (summary.missing) " of " (summary.cells) " cells miss the target." }
            li {
                "Answers below zero, answers of cells with a large error, places with surroundings nearer than a patch of \
                 the light is wide, and lights that the cells leave too much of (`trusted` in `rrf query`, the layer \
                 `trust` of a frame). `rrf query` sends rays there, `rrf render` with `--fallback gather`."
            }
            @if !scene.has_own_lights() {
                li { "The scene has no lights of its own; the test rows are lit by points and suns." }
            }
        }
    }
}

/// A row a cell, the worst first.
fn cells(run: &TransferRun) -> Result<Markup, ReportError> {
    let mut cells = read_transfer(&run.folder, &run.facts())?.cells;
    let error = |error: Option<f32>| error.map_or(f64::INFINITY, f64::from);
    cells.sort_by(|a, b| error(b.error).total_cmp(&error(a.error)));
    let rows = cells.iter().map(|cell| {
        vec![
            cell.cell_id.to_string(),
            or_dash(cell.error, |e| percent(f64::from(e))),
            cell.rows.to_string(),
            cell.judged.to_string(),
            cell.rank.to_string(),
        ]
    });
    let rows: Vec<Vec<String>> = rows.collect();
    let (first, rest) = rows.split_at(rows.len().min(SHOWN));
    let heads = ["cell", "held out", "rows", "rows held out", "coefficients"];
    Ok(html! {
        h2 { "Error by cell" }
        p.note { "Worst first, one standard error added; a dash where fewer than two rows were held out." }
        (table(&heads, first))
        @if !rest.is_empty() {
            details { summary { (rest.len()) " more" } (table(&heads, rest)) }
        }
    })
}
