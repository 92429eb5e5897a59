//! Charts as SVG and PNG, by plotters.

use super::description::{Line, Panel, Point, Series, rgb};
use super::scale::Scale;
use crate::ReportError;
use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::register_font;
use std::error::Error;
use std::path::Path;

/// Pixels of a panel.
const PANEL: (u32, u32) = (500, 440);
/// Height of the strip with the legend.
const LEGEND: u32 = 40;
/// Grey of the grid.
const GRID: RGBColor = RGBColor(225, 225, 225);

/// Pixels between the dashes of a line.
const DASH: i32 = 5;

type Drawn = Result<(), Box<dyn Error>>;

/// Panels side by side as an SVG element.
///
/// # Errors
/// [`ReportError::Draw`].
pub fn chart_svg(panels: &[Panel]) -> Result<String, ReportError> {
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, size(panels)).into_drawing_area();
        draw(&area, panels).map_err(|e| ReportError::Draw(e.to_string()))?;
    }
    Ok(text)
}

/// Writes panels side by side as a PNG file.
///
/// # Errors
/// [`ReportError::Draw`].
pub fn write_chart_png(path: &Path, panels: &[Panel]) -> Result<(), ReportError> {
    let area = BitMapBackend::new(path, size(panels)).into_drawing_area();
    draw(&area, panels).map_err(|e| ReportError::Draw(format!("{}: {e}", path.display())))
}

fn size(panels: &[Panel]) -> (u32, u32) {
    (PANEL.0 * panels.len().max(1) as u32, PANEL.1 + LEGEND)
}

fn draw<B: DrawingBackend>(area: &DrawingArea<B, Shift>, panels: &[Panel]) -> Drawn
where
    B::ErrorType: 'static,
{
    // a font that is built in: the same picture on every machine
    let font = epaint_default_fonts::UBUNTU_LIGHT;
    register_font("sans-serif", FontStyle::Normal, font)
        .map_err(|_| "the font that is built in cannot be read")?;
    area.fill(&WHITE)?;
    let (top, below) = area.split_vertically(LEGEND);
    draw_legend(&top, panels)?;
    for (area, panel) in (below.split_evenly((1, panels.len().max(1))).iter()).zip(panels) {
        draw_panel(area, panel)?;
    }
    area.present()?;
    Ok(())
}

/// An entry for each name, in the order of the series.
fn draw_legend<B: DrawingBackend>(area: &DrawingArea<B, Shift>, panels: &[Panel]) -> Drawn
where
    B::ErrorType: 'static,
{
    let style = ("sans-serif", 18).into_text_style(area);
    let (mut x, y) = (70, LEGEND as i32 / 2 + 4);
    let mut told: Vec<&str> = Vec::new();
    for series in panels.iter().flat_map(|panel| &panel.series) {
        let Some(name) = series.name.as_deref().filter(|name| !told.contains(name)) else {
            continue;
        };
        told.push(name);
        if series.has_marks() {
            area.draw(&Circle::new((x, y), 6, style_of(series).filled()))?;
        } else {
            let dash = if series.line == Line::Dashed { DASH } else { 0 };
            let line = vec![(x - 12, y), (x + 8, y)];
            area.draw(&DashedPathElement::new(line, 6, dash, style_of(series)))?;
        }
        area.draw(&Text::new(name.to_string(), (x + 14, y - 6), style.clone()))?;
        x += 48 + area.estimate_text_size(name, &style)?.0 as i32;
    }
    Ok(())
}

fn style_of(series: &Series) -> ShapeStyle {
    let (r, g, b) = rgb(series.color);
    match series.line {
        Line::Pale => BLACK.mix(0.18).stroke_width(1),
        Line::Dashed => RGBColor(r, g, b).stroke_width(1),
        _ => RGBColor(r, g, b).stroke_width(2),
    }
}

fn draw_panel<B: DrawingBackend>(area: &DrawingArea<B, Shift>, panel: &Panel) -> Drawn
where
    B::ErrorType: 'static,
{
    let points = || panel.series.iter().flat_map(|series| &series.points);
    let x = Scale::new(panel.x, points().map(|p| p.x));
    let y = Scale::new(panel.y, points().flat_map(Point::bar));
    let mut chart = ChartBuilder::on(area)
        .margin(8)
        .margin_right(22)
        .x_label_area_size(48)
        .y_label_area_size(66)
        .build_cartesian_2d(x.clone(), y.clone())?;
    chart
        .configure_mesh()
        .x_desc(panel.x.title)
        .y_desc(panel.y.title)
        .axis_desc_style(("sans-serif", 18))
        .label_style(("sans-serif", 16))
        .bold_line_style(GRID)
        .light_line_style(TRANSPARENT)
        .draw()?;
    for series in &panel.series {
        let style = style_of(series);
        let placed = || (series.points.iter()).filter(|p| x.has(p.x) && y.has(p.y));
        let line = placed().map(|p| (p.x, p.y));
        match series.line {
            Line::None => {}
            Line::Dashed => {
                chart.draw_series(DashedLineSeries::new(line, 6, DASH, style))?;
            }
            Line::Solid | Line::Pale => {
                chart.draw_series(LineSeries::new(line, style))?;
            }
        }
        chart.draw_series(placed().filter(|p| p.se > 0.0).map(|p| {
            let [low, high] = p.bar();
            ErrorBar::new_vertical(p.x, low, p.y, high, style, 8)
        }))?;
        let marks = placed().filter(|p| p.radius > 0);
        chart.draw_series(marks.map(|p| Circle::new((p.x, p.y), p.radius, style.filled())))?;
    }
    Ok(())
}
