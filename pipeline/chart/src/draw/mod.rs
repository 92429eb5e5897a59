//! Charts as SVG and PNG, by plotters.

mod axis;
mod curves;
mod panels;

pub(crate) use curves::{Curve, Curves};

use crate::ChartError;
use crate::chart::Panel;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::register_font;
use std::error::Error;
use std::path::Path;

/// Pixels of a panel.
const PANEL: (u32, u32) = (500, 440);
/// Height of the strip with the legend.
const LEGEND: u32 = 40;
/// Okabe and Ito's colours, told apart by the colour-blind too.
const COLORS: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(90, 90, 90),
    RGBColor(160, 140, 0),
];
const GRID: RGBColor = RGBColor(225, 225, 225);
const FRONT: RGBColor = RGBColor(120, 120, 120);

type Drawn = Result<(), Box<dyn Error>>;

/// The colour of the n-th method.
pub(crate) fn color(n: usize) -> RGBColor {
    COLORS[n % COLORS.len()]
}

/// Panels side by side into an SVG file.
pub(crate) fn svg(path: &Path, panels: &[Panel]) -> Result<(), ChartError> {
    let area = SVGBackend::new(path, size(panels)).into_drawing_area();
    panels::draw(&area, panels).map_err(|e| failed(path, &*e))
}

/// The same into a PNG file.
pub(crate) fn png(path: &Path, panels: &[Panel]) -> Result<(), ChartError> {
    let area = BitMapBackend::new(path, size(panels)).into_drawing_area();
    panels::draw(&area, panels).map_err(|e| failed(path, &*e))
}

/// The same as an SVG element.
pub(crate) fn svg_panels(panels: &[Panel]) -> Result<String, ChartError> {
    inline(size(panels), |area| panels::draw(area, panels))
}

/// Curves as an SVG element.
pub(crate) fn svg_curves(curves: &Curves) -> Result<String, ChartError> {
    inline((PANEL.0, PANEL.1), |area| curves::draw(area, curves))
}

fn size(panels: &[Panel]) -> (u32, u32) {
    (PANEL.0 * panels.len().max(1) as u32, PANEL.1 + LEGEND)
}

fn inline(
    size: (u32, u32),
    draw: impl FnOnce(&DrawingArea<SVGBackend, Shift>) -> Drawn,
) -> Result<String, ChartError> {
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, size).into_drawing_area();
        draw(&area).map_err(|e| failed(Path::new("picture"), &*e))?;
    }
    Ok(text)
}

fn failed(path: &Path, error: &dyn Error) -> ChartError {
    ChartError::Draw {
        path: path.to_path_buf(),
        reason: error.to_string(),
    }
}

/// A font that is built in: the same picture on every machine.
fn font() -> Drawn {
    register_font(
        "sans-serif",
        FontStyle::Normal,
        epaint_default_fonts::UBUNTU_LIGHT,
    )
    .map_err(|_| "the font that is built in cannot be read".into())
}
