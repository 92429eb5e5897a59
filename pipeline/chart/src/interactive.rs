//! Panels with hover and zoom, by plotly.js, which the page carries with it.

use crate::chart::{Joined, Panel, methods};
use crate::draw::color;
use crate::front::Point;
use crate::html;
use crate::results::Row;
use plotly::common::{DashType, ErrorData, ErrorType, HoverInfo, Line, Marker, Mode, Title};
use plotly::layout::{Axis, AxisType, Margin};
use plotly::{Layout, Plot, Scatter};

/// plotly.js (MIT) as a script element; MathJax, which the crate puts beside it, is left out.
pub(crate) fn script() -> String {
    let all = Plot::offline_js_sources();
    let first = all.split_once("</script>").map_or("", |(first, _)| first);
    format!("{first}</script>")
}

/// One plot a panel, each under its heading.
pub(crate) fn plots(panels: &[Panel]) -> String {
    let methods = methods(panels);
    let mut body = String::new();
    for (number, panel) in panels.iter().enumerate() {
        body += &format!(
            "<h2>Error against {}</h2>\n<div class=\"plot\">",
            panel.cost
        );
        body += &plot(panel, &methods).to_inline_html(Some(&format!("panel{number}")));
        body += "</div>\n";
    }
    body
}

fn plot(panel: &Panel, methods: &[String]) -> Plot {
    let mut plot = Plot::new();
    if panel.joined == Joined::Front {
        let front: Vec<&Point> = panel.points.iter().filter(|p| p.on_front).collect();
        plot.add_trace(line(
            coordinates(&front),
            "front",
            "#888888",
            DashType::Solid,
        ));
    }
    if let Some(target) = panel.target {
        let costs = || panel.points.iter().map(|p| p.cost.mean);
        let ends = vec![
            costs().fold(f64::INFINITY, f64::min),
            costs().fold(0.0, f64::max),
        ];
        let level = (ends, vec![target, target]);
        plot.add_trace(line(level, "target", "#888888", DashType::Dash));
    }
    for (n, method) in methods.iter().enumerate() {
        let mine: Vec<&Point> = (panel.points.iter())
            .filter(|p| p.method == *method)
            .collect();
        if mine.is_empty() {
            continue;
        }
        let (x, y) = coordinates(&mine);
        let rgb = color(n);
        let rgb = format!("rgb({},{},{})", rgb.0, rgb.1, rgb.2);
        let bars = mine.iter().map(|p| p.error.se).collect();
        let mode = match panel.joined {
            Joined::Front => Mode::Markers,
            Joined::Method => Mode::LinesMarkers,
        };
        plot.add_trace(
            Scatter::new(x, y)
                .mode(mode)
                .name(method)
                .marker(Marker::new().size(10).color(rgb.clone()))
                .line(Line::new().color(rgb))
                .text_array(mine.iter().map(|p| hover(p)).collect::<Vec<_>>())
                .hover_info(HoverInfo::Text)
                .error_y(ErrorData::new(ErrorType::Data).array(bars)),
        );
    }
    let axis = |title: &str| {
        Axis::new()
            .title(Title::from(title))
            .type_(AxisType::Log)
            .auto_margin(true)
            .grid_color("#e1e1e1")
    };
    let margin = Margin::new().top(10).right(20);
    plot.set_layout(
        Layout::new()
            .x_axis(axis(panel.cost))
            .y_axis(axis(panel.error))
            .margin(margin)
            .plot_background_color("#ffffff"),
    );
    plot
}

/// A line without points, told of in the legend alone.
fn line(
    (x, y): (Vec<f64>, Vec<f64>),
    name: &str,
    color: &'static str,
    dash: DashType,
) -> Box<Scatter<f64, f64>> {
    Scatter::new(x, y)
        .mode(Mode::Lines)
        .name(name)
        .hover_info(HoverInfo::Skip)
        .line(Line::new().color(color).dash(dash))
}

fn coordinates(points: &[&Point]) -> (Vec<f64>, Vec<f64>) {
    points.iter().map(|p| (p.cost.mean, p.error.mean)).unzip()
}

fn hover(p: &Point) -> String {
    html::escape(&format!(
        "{}: {} ({}): error {:.2} ± {:.2} %, cost {:.4}",
        p.method,
        p.setting,
        match p.seeds {
            1 => "1 seed".into(),
            n => format!("{n} seeds"),
        },
        p.error.mean,
        p.error.se,
        p.cost.mean
    ))
}

/// A sweep's runs as a table.
pub(crate) fn runs(rows: &[Row]) -> String {
    let percent = |x: f64| format!("{:.2} %", 100.0 * x);
    let or_dash = |text: Option<String>| text.unwrap_or_else(|| "–".into());
    let lines: Vec<Vec<String>> = (rows.iter())
        .map(|r| {
            vec![
                r.method.clone(),
                r.setting.clone(),
                r.seed.to_string(),
                or_dash(r.bake_cpu_seconds.map(|s| format!("{s:.1}"))),
                or_dash(r.bake_seconds.map(|s| format!("{s:.1}"))),
                format!("{:.3}", r.frame_cpu_seconds),
                format!("{:.3}", r.frame_seconds),
                or_dash(r.model_bytes.map(|b| b.to_string())),
                or_dash(r.held_out_error.map(percent)),
                or_dash(r.points_error.map(percent)),
                percent(r.frame_error),
                format!("{:.4}", r.flip),
                format!("{:.2}", r.delta_e_2000),
            ]
        })
        .collect();
    let heads = [
        "method",
        "setting",
        "seed",
        "bake [CPU s]",
        "bake [s]",
        "frame [CPU s]",
        "frame [s]",
        "model [bytes]",
        "held out",
        "points",
        "frame",
        "FLIP",
        "ΔE2000",
    ];
    format!("<h2>Runs</h2>\n{}", html::table(&heads, &lines))
}
