//! `rrf chart`: Pareto fronts of error against what it costs.

use crate::front::{Point, points};
use crate::results::Row;
use crate::{ChartError, draw, html, interactive};
use std::path::{Path, PathBuf};

/// One panel: an error against a cost, both positive and on logarithmic axes.
#[derive(Clone, Debug)]
pub struct Panel {
    /// What the horizontal axis says.
    pub cost: &'static str,
    /// A point a setting.
    pub points: Vec<Point>,
}

/// What the vertical axis of every panel says.
pub const ERROR: &str = "relative error of the frame's indirect light [%]";

/// A cost of a run; none where it has none.
type Cost = fn(&Row) -> Option<f64>;

/// The panels that the rows can fill: bake time, frame time, model size.
pub fn panels(rows: &[Row]) -> Vec<Panel> {
    let error = |row: &Row| Some(100.0 * row.frame_error).filter(|e| *e > 0.0);
    let costs: [(&str, Cost); 3] = [
        ("bake time [s]", |row| row.bake_seconds),
        ("time of a frame [s]", |row| Some(row.frame_seconds)),
        ("model [bytes]", |row| row.model_bytes.map(|b| b as f64)),
    ];
    costs
        .map(|(name, cost)| Panel {
            cost: name,
            points: points(rows, |row| cost(row).filter(|c| *c > 0.0), error),
        })
        .into_iter()
        .filter(|panel| !panel.points.is_empty())
        .collect()
}

/// Methods in the order of their colours.
pub(crate) fn methods(panels: &[Panel]) -> Vec<String> {
    let mut methods: Vec<String> = (panels.iter())
        .flat_map(|panel| panel.points.iter().map(|p| p.method.clone()))
        .collect();
    methods.sort();
    methods.dedup();
    methods
}

/// Writes `frontier.svg`, `frontier.png` and `frontier.html`; their paths.
///
/// # Errors
/// [`ChartError::Table`] where there is nothing to draw, [`ChartError::Draw`],
/// [`ChartError::File`].
pub fn write(folder: &Path, source: &Path, rows: &[Row]) -> Result<Vec<PathBuf>, ChartError> {
    let panels = panels(rows);
    if panels.is_empty() {
        return Err(ChartError::Table {
            path: source.to_path_buf(),
            reason: "no run in it has an error above zero: nothing to draw".into(),
        });
    }
    std::fs::create_dir_all(folder).map_err(|e| ChartError::file(folder, "be made", e))?;
    let [svg, png, page] =
        ["svg", "png", "html"].map(|ending| folder.join(format!("frontier.{ending}")));
    draw::svg(&svg, &panels)?;
    draw::png(&png, &panels)?;
    let body = interactive::body(&panels, rows);
    html::write(
        &page,
        "Error against time and size",
        &interactive::script(),
        &body,
    )?;
    Ok(vec![svg, png, page])
}
