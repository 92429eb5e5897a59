//! Panels with hover and zoom, by plotly.js, which the page carries with it.

use crate::chart::{ERROR, Panel, methods};
use crate::draw::color;
use crate::front::Point;
use crate::html;
use crate::results::Row;
use plotly::common::{ErrorData, ErrorType, HoverInfo, Line, Marker, Mode, Title};
use plotly::layout::{Axis, AxisType};
use plotly::{Layout, Plot, Scatter};

/// plotly.js (MIT) as a script element; MathJax, which the crate puts beside it, is left out.
pub(crate) fn script() -> String {
    let all = Plot::offline_js_sources();
    let first = all.split_once("</script>").map_or("", |(first, _)| first);
    format!("{first}</script>")
}

/// The panels and the table behind them.
pub(crate) fn body(panels: &[Panel], rows: &[Row]) -> String {
    let methods = methods(panels);
    let mut body = String::from(
        "<p>Each point is a setting, its bar one standard error over the seeds. The line joins the \
         settings that no other beats in both. Hover for the setting, drag to zoom.</p>\n",
    );
    for (number, panel) in panels.iter().enumerate() {
        body += &format!(
            "<h2>Error against {}</h2>\n<div class=\"plot\">",
            panel.cost
        );
        body += &plot(panel, &methods).to_inline_html(Some(&format!("panel{number}")));
        body += "</div>\n";
    }
    body + "<h2>Runs</h2>\n" + &table(rows)
}

fn plot(panel: &Panel, methods: &[String]) -> Plot {
    let mut plot = Plot::new();
    let front: Vec<&Point> = panel.points.iter().filter(|p| p.on_front).collect();
    let (x, y) = coordinates(&front);
    plot.add_trace(
        Scatter::new(x, y)
            .mode(Mode::Lines)
            .name("front")
            .hover_info(HoverInfo::Skip)
            .line(Line::new().color("#888888")),
    );
    for (n, method) in methods.iter().enumerate() {
        let mine: Vec<&Point> = (panel.points.iter())
            .filter(|p| p.method == *method)
            .collect();
        if mine.is_empty() {
            continue;
        }
        let (x, y) = coordinates(&mine);
        let rgb = color(n);
        let marker = Marker::new()
            .size(10)
            .color(format!("rgb({},{},{})", rgb.0, rgb.1, rgb.2));
        let bars = mine.iter().map(|p| p.error.se).collect();
        plot.add_trace(
            Scatter::new(x, y)
                .mode(Mode::Markers)
                .name(method)
                .marker(marker)
                .text_array(mine.iter().map(|p| hover(p)).collect::<Vec<_>>())
                .hover_info(HoverInfo::Text)
                .error_y(ErrorData::new(ErrorType::Data).array(bars)),
        );
    }
    let axis = |title: &str| Axis::new().title(Title::from(title)).type_(AxisType::Log);
    plot.set_layout(Layout::new().x_axis(axis(panel.cost)).y_axis(axis(ERROR)));
    plot
}

fn coordinates(points: &[&Point]) -> (Vec<f64>, Vec<f64>) {
    points.iter().map(|p| (p.cost.mean, p.error.mean)).unzip()
}

fn hover(p: &Point) -> String {
    html::escape(&format!(
        "{}: {} ({} seeds): error {:.2} ± {:.2} %, cost {:.4}",
        p.method, p.setting, p.seeds, p.error.mean, p.error.se, p.cost.mean
    ))
}

fn table(rows: &[Row]) -> String {
    let percent = |x: f64| format!("{:.2} %", 100.0 * x);
    let or_dash = |text: Option<String>| text.unwrap_or_else(|| "–".into());
    let lines: Vec<Vec<String>> = (rows.iter())
        .map(|r| {
            vec![
                r.method.clone(),
                r.setting.clone(),
                r.seed.to_string(),
                or_dash(r.bake_seconds.map(|s| format!("{s:.1}"))),
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
        "bake [s]",
        "frame [s]",
        "model [bytes]",
        "held out",
        "points",
        "frame",
        "FLIP",
        "ΔE2000",
    ];
    html::table(&heads, &lines)
}
