//! Charts: one description, drawn as SVG and PNG and as a page with hover and zoom.

mod description;
mod draw;
mod interactive;
mod scale;

pub use description::{Axis, Line, Panel, Point, Series};
pub use draw::chart_svg;

use crate::{ReportError, html};
use draw::write_chart_png;
use maud::{Markup, html};
use std::path::{Path, PathBuf};

/// Panels with a name, and what their page says.
pub struct Chart<'a> {
    /// Name of the files, without their endings.
    pub name: &'a str,
    /// Title of the page.
    pub title: &'a str,
    /// The panels.
    pub panels: &'a [Panel],
    /// Above the panels.
    pub about: Markup,
    /// Under the panels.
    pub below: Markup,
}

impl Chart<'_> {
    /// Writes the chart as SVG, PNG and HTML into `folder`; gives their paths.
    ///
    /// # Errors
    /// [`ReportError::Draw`], [`ReportError::File`].
    pub fn write_files(self, folder: &Path) -> Result<Vec<PathBuf>, ReportError> {
        rrf_files::make_folder(folder).map_err(|e| ReportError::file(folder, "be made", e))?;
        let [svg, png, page] =
            ["svg", "png", "html"].map(|ending| folder.join(format!("{}.{ending}", self.name)));
        let text = chart_svg(self.panels)?;
        rrf_files::replace(&svg, text.as_bytes())
            .map_err(|e| ReportError::file(&svg, "be written", e))?;
        write_chart_png(&png, self.panels)?;
        let plots = interactive::interactive_plots(self.panels);
        let body = html! { (self.about) (plots) (self.below) };
        html::write_page(&page, self.title, interactive::script(), body)?;
        Ok(vec![svg, png, page])
    }
}
