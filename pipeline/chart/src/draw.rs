//! Panels as SVG and PNG, by plotters.

use crate::ChartError;
use crate::chart::{ERROR, Panel, methods};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::register_font;
use std::error::Error;
use std::path::Path;

const SIZE: (u32, u32) = (1500, 520);
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

/// The colour of the n-th method.
pub(crate) fn color(n: usize) -> RGBColor {
    COLORS[n % COLORS.len()]
}

pub(crate) fn svg(path: &Path, panels: &[Panel]) -> Result<(), ChartError> {
    draw(SVGBackend::new(path, SIZE).into_drawing_area(), panels).map_err(|e| failed(path, &*e))
}

pub(crate) fn png(path: &Path, panels: &[Panel]) -> Result<(), ChartError> {
    draw(BitMapBackend::new(path, SIZE).into_drawing_area(), panels).map_err(|e| failed(path, &*e))
}

fn failed(path: &Path, error: &dyn Error) -> ChartError {
    ChartError::Draw {
        path: path.to_path_buf(),
        reason: error.to_string(),
    }
}

fn draw<B: DrawingBackend>(
    area: DrawingArea<B, Shift>,
    panels: &[Panel],
) -> Result<(), Box<dyn Error>>
where
    B::ErrorType: 'static,
{
    register_font(
        "sans-serif",
        FontStyle::Normal,
        epaint_default_fonts::UBUNTU_LIGHT,
    )
    .map_err(|_| "the font that is built in cannot be read")?;
    area.fill(&WHITE)?;
    let methods = methods(panels);
    for (area, panel) in area.split_evenly((1, panels.len())).iter().zip(panels) {
        one(area, panel, &methods)?;
    }
    area.present()?;
    Ok(())
}

fn one<B: DrawingBackend>(
    area: &DrawingArea<B, Shift>,
    panel: &Panel,
    methods: &[String],
) -> Result<(), Box<dyn Error>>
where
    B::ErrorType: 'static,
{
    let (x, y) = ranges(panel);
    let mut chart = ChartBuilder::on(area)
        .margin(14)
        .x_label_area_size(46)
        .y_label_area_size(62)
        .build_cartesian_2d(x.log_scale(), y.log_scale())?;
    chart
        .configure_mesh()
        .x_desc(panel.cost)
        .y_desc(ERROR)
        .axis_desc_style(("sans-serif", 17))
        .label_style(("sans-serif", 14))
        .x_labels(8)
        .bold_line_style(RGBColor(215, 215, 215))
        .light_line_style(TRANSPARENT)
        .x_label_formatter(&|x: &f64| tidy(*x))
        .y_label_formatter(&|y: &f64| tidy(*y))
        .draw()?;
    let front = panel.points.iter().filter(|p| p.on_front);
    chart.draw_series(LineSeries::new(
        front.map(|p| (p.cost.mean, p.error.mean)),
        RGBColor(120, 120, 120).stroke_width(2),
    ))?;
    for (n, method) in methods.iter().enumerate() {
        let style = color(n);
        let mine = || panel.points.iter().filter(|p| p.method == *method);
        // a bar below zero has no place on a logarithmic axis: it ends at the axis
        let low = |p: &crate::front::Point| (p.error.mean - p.error.se).max(0.5 * p.error.mean);
        chart.draw_series(mine().filter(|p| p.error.se > 0.0).map(|p| {
            let (cost, error) = (p.cost.mean, p.error);
            ErrorBar::new_vertical(cost, low(p), error.mean, error.mean + error.se, style, 7)
        }))?;
        chart
            .draw_series(mine().map(|p| {
                let size = if p.on_front { 6 } else { 4 };
                Circle::new((p.cost.mean, p.error.mean), size, style.filled())
            }))?
            .label(method.clone())
            .legend(move |(x, y)| Circle::new((x + 8, y), 5, style.filled()));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .label_font(("sans-serif", 15))
        .background_style(WHITE.mix(0.8))
        .border_style(RGBColor(200, 200, 200))
        .draw()?;
    Ok(())
}

/// Axes of whole decades: a logarithmic axis of less has hardly a label.
fn ranges(panel: &Panel) -> (std::ops::Range<f64>, std::ops::Range<f64>) {
    let range = |values: &mut dyn Iterator<Item = f64>| {
        let (low, high) = values.fold((f64::INFINITY, 0.0f64), |(low, high), x| {
            (low.min(x), high.max(x))
        });
        let decade = |x: f64| 10f64.powf(x);
        decade((low / 1.1).log10().floor())..decade((high * 1.1).log10().ceil())
    };
    let points = &panel.points;
    (
        range(&mut points.iter().map(|p| p.cost.mean)),
        range(&mut points.iter().flat_map(|p| {
            let (mean, se) = (p.error.mean, p.error.se);
            [(mean - se).max(0.5 * mean), mean + se]
        })),
    )
}

/// 2000000 as 2M, 0.0300 as 0.03.
fn tidy(x: f64) -> String {
    if x >= 1e6 {
        format!("{}M", round(x / 1e6))
    } else if x >= 1e3 {
        format!("{}k", round(x / 1e3))
    } else {
        round(x)
    }
}

/// Two digits that count.
fn round(x: f64) -> String {
    let digits = (1 - x.abs().log10().floor() as i32).clamp(0, 9) as usize;
    let text = format!("{x:.digits$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_string()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_short() {
        for (x, wanted) in [
            (0.03, "0.03"),
            (1.0, "1"),
            (2.5, "2.5"),
            (30.0, "30"),
            (20_000.0, "20k"),
            (1.5e6, "1.5M"),
        ] {
            assert_eq!(tidy(x), wanted);
        }
    }
}
