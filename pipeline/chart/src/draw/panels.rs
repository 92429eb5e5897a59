//! Error against costs, both logarithmic; one legend for all panels.

use super::axis::{range, ticks, tidy};
use super::{Drawn, FRONT, GRID, LEGEND, color, font};
use crate::chart::{Joined, Panel, methods};
use crate::front::Point;
use plotters::coord::Shift;
use plotters::coord::combinators::BindKeyPoints;
use plotters::prelude::*;

/// Space that a range has beyond its values, as a share of its logarithm.
const MARGIN: f64 = 0.06;

pub(super) fn draw<B: DrawingBackend>(area: &DrawingArea<B, Shift>, panels: &[Panel]) -> Drawn
where
    B::ErrorType: 'static,
{
    font()?;
    area.fill(&WHITE)?;
    let methods = methods(panels);
    let (top, below) = area.split_vertically(LEGEND);
    legend(&top, panels, &methods)?;
    let areas = below.split_evenly((1, panels.len().max(1)));
    for (area, panel) in areas.iter().zip(panels) {
        one(area, panel, &methods)?;
    }
    area.present()?;
    Ok(())
}

/// A dot and a name a method, and what the line joins.
fn legend<B: DrawingBackend>(
    area: &DrawingArea<B, Shift>,
    panels: &[Panel],
    methods: &[String],
) -> Drawn
where
    B::ErrorType: 'static,
{
    let style = ("sans-serif", 18).into_text_style(area);
    let (mut x, y) = (70, LEGEND as i32 / 2 + 4);
    let mut put = |text: &str, mark: Option<RGBColor>| -> Drawn {
        match mark {
            Some(mark) => area.draw(&Circle::new((x, y), 6, mark.filled()))?,
            None => area.draw(&PathElement::new(
                vec![(x - 12, y), (x + 8, y)],
                FRONT.stroke_width(2),
            ))?,
        }
        area.draw(&Text::new(text.to_string(), (x + 14, y - 6), style.clone()))?;
        x += 48 + area.estimate_text_size(text, &style)?.0 as i32;
        Ok(())
    };
    for (n, method) in methods.iter().enumerate() {
        put(method, Some(color(n)))?;
    }
    if panels.iter().any(|p| p.joined == Joined::Front) {
        put("nothing is both cheaper and better", None)?;
    }
    Ok(())
}

fn one<B: DrawingBackend>(area: &DrawingArea<B, Shift>, panel: &Panel, methods: &[String]) -> Drawn
where
    B::ErrorType: 'static,
{
    let (x, y) = ranges(panel);
    let (x_ticks, y_ticks) = (ticks(&x), ticks(&y));
    let right = x.end;
    let mut chart = ChartBuilder::on(area)
        .margin(8)
        .margin_right(22)
        .x_label_area_size(48)
        .y_label_area_size(66)
        .build_cartesian_2d(
            x.clone().log_scale().with_key_points(x_ticks),
            y.log_scale().with_key_points(y_ticks),
        )?;
    chart
        .configure_mesh()
        .x_desc(panel.cost)
        .y_desc(panel.error)
        .axis_desc_style(("sans-serif", 18))
        .label_style(("sans-serif", 16))
        .bold_line_style(GRID)
        .light_line_style(TRANSPARENT)
        .x_label_formatter(&|x: &f64| tidy(*x))
        .y_label_formatter(&|y: &f64| tidy(*y))
        .draw()?;
    if let Some(target) = panel.target {
        let line = vec![(x.start, target), (right, target)];
        chart.draw_series(DashedLineSeries::new(line, 6, 5, FRONT.stroke_width(1)))?;
    }
    if panel.joined == Joined::Front {
        let front = panel.points.iter().filter(|p| p.on_front);
        let line = front.map(|p| (p.cost.mean, p.error.mean));
        chart.draw_series(LineSeries::new(line, FRONT.stroke_width(2)))?;
    }
    for (n, method) in methods.iter().enumerate() {
        let style = color(n);
        let mine = || panel.points.iter().filter(|p| p.method == *method);
        if panel.joined == Joined::Method {
            let line = mine().map(|p| (p.cost.mean, p.error.mean));
            chart.draw_series(LineSeries::new(line, style.stroke_width(2)))?;
        }
        chart.draw_series(mine().filter(|p| p.error.se > 0.0).map(|p| {
            let (cost, error) = (p.cost.mean, p.error);
            ErrorBar::new_vertical(cost, low(p), error.mean, error.mean + error.se, style, 8)
        }))?;
        chart.draw_series(mine().map(|p| {
            let size = if p.on_front { 6 } else { 4 };
            Circle::new((p.cost.mean, p.error.mean), size, style.filled())
        }))?;
    }
    Ok(())
}

/// Lower end of a bar: one below zero has no place on a logarithmic axis and is cut at half.
fn low(p: &Point) -> f64 {
    (p.error.mean - p.error.se).max(0.5 * p.error.mean)
}

type Range = std::ops::Range<f64>;

fn ranges(panel: &Panel) -> (Range, Range) {
    let points = &panel.points;
    let errors = points
        .iter()
        .flat_map(|p| [low(p), p.error.mean + p.error.se]);
    (
        range(points.iter().map(|p| p.cost.mean), MARGIN),
        range(errors.chain(panel.target), MARGIN),
    )
}
