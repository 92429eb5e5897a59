//! Charts with hover and zoom, by plotly.js, which the page carries with it.

use super::description::{Axis, Line, Panel, Series, rgb};
use maud::{Markup, PreEscaped, html};
use plotly::common::{DashType, ErrorData, ErrorType, HoverInfo, Marker, Mode, Title};
use plotly::layout::{AxisType, Margin};
use plotly::{Layout, Plot, Scatter, common, layout};

/// plotly.js (MIT) as a script element; MathJax, which the crate puts beside it, is left out.
pub fn script() -> Markup {
    let all = Plot::offline_js_sources();
    let first = all.split_once("</script>").map_or("", |(first, _)| first);
    PreEscaped(format!("{first}</script>"))
}

/// One plot a panel, each under its heading.
pub fn interactive_plots(panels: &[Panel]) -> Markup {
    html! {
        @for (number, panel) in panels.iter().enumerate() {
            h2 { "Error against " (panel.x.title) }
            div.plot { (PreEscaped(plot(panel).to_inline_html(Some(&format!("panel{number}"))))) }
        }
    }
}

fn plot(panel: &Panel) -> Plot {
    let mut plot = Plot::new();
    for series in &panel.series {
        plot.add_trace(trace(series));
    }
    plot.set_layout(
        Layout::new()
            .x_axis(axis(panel.x))
            .y_axis(axis(panel.y))
            .margin(Margin::new().top(10).right(20))
            .plot_background_color("#ffffff"),
    );
    plot
}

fn trace(series: &Series) -> Box<Scatter<f64, f64>> {
    let (r, g, b) = rgb(series.color);
    let color = format!("rgb({r},{g},{b})");
    let dash = match series.line {
        Line::Dashed => DashType::Dash,
        _ => DashType::Solid,
    };
    let points = series.points.iter();
    let trace = Scatter::new(
        points.clone().map(|p| p.x).collect(),
        points.clone().map(|p| p.y).collect(),
    )
    .name(series.name.as_deref().unwrap_or_default())
    .line(common::Line::new().color(color.clone()).dash(dash));
    if !series.has_marks() {
        return trace.mode(Mode::Lines).hover_info(HoverInfo::Skip);
    }
    // plotly reads markup in texts
    let texts = points.clone().map(|p| html! { (p.text) }.into_string());
    let bars = points.map(|p| p.se).collect();
    trace
        .mode(match series.line {
            Line::None => Mode::Markers,
            _ => Mode::LinesMarkers,
        })
        .marker(Marker::new().size(10).color(color))
        .text_array(texts.collect::<Vec<_>>())
        .hover_info(HoverInfo::Text)
        .error_y(ErrorData::new(ErrorType::Data).array(bars))
}

fn axis(axis: Axis) -> layout::Axis {
    let scale = if axis.is_log {
        AxisType::Log
    } else {
        AxisType::Linear
    };
    layout::Axis::new()
        .title(Title::from(axis.title))
        .type_(scale)
        .auto_margin(true)
        .grid_color("#e1e1e1")
}
