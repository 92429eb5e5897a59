//! Pages that need nothing from outside.

use crate::ChartError;
use rrf_store::atomic::atomic_write;
use std::path::Path;

const STYLE: &str = "body{font:15px/1.5 system-ui,sans-serif;max-width:1200px;margin:2em auto;\
    padding:0 1em;color:#222}h1{font-size:1.6em}h2{margin-top:2em;font-size:1.25em}\
    table{border-collapse:collapse;margin:.5em 0}td,th{border-bottom:1px solid #ddd;\
    padding:.2em .8em;text-align:left;font-variant-numeric:tabular-nums}th{font-weight:600}\
    td.n,th.n{text-align:right;white-space:nowrap}figure{display:inline-block;margin:.5em;vertical-align:top}\
    figcaption{font-size:.85em;color:#555}img{image-rendering:pixelated;width:320px;max-width:100%}svg{max-width:100%;height:auto}\
    code{background:#f3f3f3;padding:0 .2em}.plot{height:460px}.note{color:#555}";

/// Writes a page; `head` is script, `body` HTML, both as they are.
pub(crate) fn write(path: &Path, title: &str, head: &str, body: &str) -> Result<(), ChartError> {
    let title = escape(title);
    let page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <title>{title}</title>\n<style>{STYLE}</style>\n{head}\n</head>\n<body>\n\
         <h1>{title}</h1>\n{body}</body>\n</html>\n"
    );
    Ok(atomic_write(path, page.as_bytes())?)
}

/// Text for HTML.
pub(crate) fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            other => out.push(other),
        }
    }
    out
}

/// A table; cells that are numbers stand to the right.
pub(crate) fn table(heads: &[&str], rows: &[Vec<String>]) -> String {
    let number = |text: &str| {
        let first = text.split([' ', '±', '%']).next().unwrap_or("");
        first.replace(',', "").parse::<f64>().is_ok()
    };
    let heads: String = heads
        .iter()
        .map(|head| format!("<th>{}</th>", escape(head)))
        .collect();
    let rows = rows.iter().map(|row| {
        let cells = row.iter().map(|cell| {
            let class = if number(cell) { " class=\"n\"" } else { "" };
            format!("<td{class}>{}</td>", escape(cell))
        });
        format!("<tr>{}</tr>\n", cells.collect::<String>())
    });
    format!(
        "<table>\n<tr>{heads}</tr>\n{}</table>\n",
        rows.collect::<String>()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_of_a_name_becomes_markup() {
        let table = table(
            &["a"],
            &[vec!["<script>\"&".into()], vec!["1.5 ± 2".into()]],
        );
        assert!(
            table.contains("<td>&lt;script&gt;&quot;&amp;</td>"),
            "{table}"
        );
        assert!(table.contains("<td class=\"n\">1.5 ± 2</td>"), "{table}");
    }
}
