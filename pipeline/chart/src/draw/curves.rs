//! Many curves over one linear axis: how fits went.

use super::axis::{range, ticks, tidy};
use super::{Drawn, GRID, color, font};
use plotters::coord::Shift;
use plotters::coord::combinators::BindKeyPoints;
use plotters::prelude::*;

/// One curve; those with a name are drawn in colour, above the others.
pub(crate) struct Curve {
    pub(crate) name: Option<String>,
    /// Ascending; values that are not above zero have no place and break no line.
    pub(crate) points: Vec<(f64, f64)>,
}

/// A chart of them, logarithmic upwards.
pub(crate) struct Curves {
    pub(crate) x: &'static str,
    pub(crate) y: &'static str,
    pub(crate) curves: Vec<Curve>,
}

pub(super) fn draw<B: DrawingBackend>(area: &DrawingArea<B, Shift>, all: &Curves) -> Drawn
where
    B::ErrorType: 'static,
{
    font()?;
    area.fill(&WHITE)?;
    let points = || all.curves.iter().flat_map(|curve| &curve.points);
    let right = points().map(|p| p.0).fold(1.0, f64::max);
    let y = range(points().map(|p| p.1), 0.04);
    let y_ticks = ticks(&y);
    let mut chart = ChartBuilder::on(area)
        .margin(8)
        .margin_right(22)
        .x_label_area_size(48)
        .y_label_area_size(66)
        .build_cartesian_2d(0.0..right, y.log_scale().with_key_points(y_ticks))?;
    chart
        .configure_mesh()
        .x_desc(all.x)
        .y_desc(all.y)
        .axis_desc_style(("sans-serif", 18))
        .label_style(("sans-serif", 16))
        .bold_line_style(GRID)
        .light_line_style(TRANSPARENT)
        .x_labels(8)
        .x_label_formatter(&|x: &f64| tidy(*x))
        .y_label_formatter(&|y: &f64| tidy(*y))
        .draw()?;
    let placed = |curve: &Curve| -> Vec<(f64, f64)> {
        let above = curve.points.iter().filter(|p| p.1 > 0.0 && p.1.is_finite());
        above.copied().collect()
    };
    for curve in all.curves.iter().filter(|c| c.name.is_none()) {
        chart.draw_series(LineSeries::new(
            placed(curve),
            BLACK.mix(0.18).stroke_width(1),
        ))?;
    }
    let named = all
        .curves
        .iter()
        .filter_map(|c| Some((c.name.as_ref()?, c)));
    for (n, (name, curve)) in named.enumerate() {
        let style = color(n);
        chart
            .draw_series(LineSeries::new(placed(curve), style.stroke_width(2)))?
            .label(name.clone())
            .legend(move |(x, y)| {
                PathElement::new(vec![(x, y), (x + 16, y)], style.stroke_width(2))
            });
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .label_font(("sans-serif", 16))
        .background_style(WHITE.mix(0.8))
        .border_style(GRID)
        .draw()?;
    area.present()?;
    Ok(())
}
