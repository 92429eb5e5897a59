//! `rrf chart`: error against what it costs, of sweeps and of runs.

use crate::front::{Point, points};
use crate::results::Row;
use crate::{ChartError, draw, html, interactive};
use std::path::{Path, PathBuf};

/// What the line of a panel joins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Joined {
    /// The points that none is both cheaper and better than.
    Front,
    /// The points of each method, in their order.
    Method,
}

/// One panel: an error against a cost, both positive and on logarithmic axes.
#[derive(Clone, Debug)]
pub struct Panel {
    /// What the horizontal axis says.
    pub cost: &'static str,
    /// What the vertical axis says.
    pub error: &'static str,
    /// Its points; those of one method have one colour.
    pub points: Vec<Point>,
    /// What the line joins.
    pub joined: Joined,
    /// An error that is asked for.
    pub target: Option<f64>,
}

/// What the vertical axis of a sweep's panels says.
const ERROR: &str = "error of the frame's indirect light [%]";

/// A cost of a run; none where it has none.
type Cost = fn(&Row) -> Option<f64>;

/// The panels that a sweep's rows can fill: bake time, frame time, model size.
pub fn panels(rows: &[Row]) -> Vec<Panel> {
    let error = |row: &Row| Some(100.0 * row.frame_error).filter(|e| *e > 0.0);
    let costs: [(&str, Cost); 3] = [
        ("CPU time of the bake [s]", |row| row.bake_cpu_seconds),
        ("CPU time of a frame [s]", |row| Some(row.frame_cpu_seconds)),
        ("model [bytes]", |row| row.model_bytes.map(|b| b as f64)),
    ];
    costs
        .map(|(name, cost)| Panel {
            cost: name,
            error: ERROR,
            points: points(rows, |row| cost(row).filter(|c| *c > 0.0), error),
            joined: Joined::Front,
            target: None,
        })
        .into_iter()
        .filter(|panel| !panel.points.is_empty())
        .collect()
}

/// Methods in the order of their colours: the first that is drawn is the first in the legend.
pub(crate) fn methods(panels: &[Panel]) -> Vec<String> {
    let mut methods: Vec<String> = (panels.iter())
        .flat_map(|panel| panel.points.iter().map(|p| p.method.clone()))
        .collect();
    methods.sort();
    methods.dedup();
    methods
}

/// What a chart is called and what its page says besides.
pub(crate) struct Sheet<'a> {
    /// Name of the files, without their endings.
    pub(crate) name: &'a str,
    pub(crate) title: &'a str,
    /// HTML above the panels.
    pub(crate) about: &'a str,
    /// HTML under them.
    pub(crate) below: &'a str,
}

/// Writes a sweep's `frontier.svg`, `frontier.png` and `frontier.html`; their paths.
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
    let sheet = Sheet {
        name: "frontier",
        title: "Error against time and size",
        about: "<p>Each point is a setting, its bar one standard error over the seeds. The line \
                joins the settings that no other beats in both. CPU time is of \
                all cores together: it hardly depends on what else the machine does, which the \
                wall times in the table do. The error is the relative error \
                of the frame's indirect light against a path-traced reference, the reference's \
                noise taken out. Hover for the setting, drag to zoom, double-click to zoom \
                out.</p>\n",
        below: &interactive::runs(rows),
    };
    files(folder, &panels, &sheet)
}

/// Writes panels as SVG, PNG and a page.
pub(crate) fn files(
    folder: &Path,
    panels: &[Panel],
    sheet: &Sheet,
) -> Result<Vec<PathBuf>, ChartError> {
    std::fs::create_dir_all(folder).map_err(|e| ChartError::file(folder, "be made", e))?;
    let [svg, png, page] =
        ["svg", "png", "html"].map(|ending| folder.join(format!("{}.{ending}", sheet.name)));
    draw::svg(&svg, panels)?;
    draw::png(&png, panels)?;
    let body = format!(
        "{}{}{}",
        sheet.about,
        interactive::plots(panels),
        sheet.below
    );
    html::write(&page, sheet.title, &interactive::script(), &body)?;
    Ok(vec![svg, png, page])
}
