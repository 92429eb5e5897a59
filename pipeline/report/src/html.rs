//! Pages that need nothing from outside.

use crate::ReportError;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use rrf_store::atomic::atomic_write;
use std::path::Path;

/// Writes a page; `head` stands in its head besides the style.
pub(crate) fn write_page(
    path: &Path,
    title: &str,
    head: Markup,
    body: Markup,
) -> Result<(), ReportError> {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                title { (title) }
                style { (PreEscaped(include_str!("page.css"))) }
                (head)
            }
            body { h1 { (title) } (body) }
        }
    };
    Ok(atomic_write(path, page.into_string().as_bytes())?)
}

/// A table; cells that are numbers stand to the right.
pub(crate) fn table(heads: &[&str], rows: &[Vec<String>]) -> Markup {
    let class = |text: &str| {
        let first = text.split([' ', '±', '%']).next().unwrap_or("");
        let is_number = first.replace(',', "").parse::<f64>().is_ok();
        is_number.then_some("n")
    };
    html! {
        table {
            tr { @for head in heads { th { (head) } } }
            @for row in rows {
                tr { @for cell in row { td class=[class(cell)] { (cell) } } }
            }
        }
    }
}

/// A share in percent.
pub(crate) fn percent(x: f64) -> String {
    format!("{:.2} %", 100.0 * x)
}

/// A share and its standard error in percent.
pub(crate) fn percent_se((x, se): (f64, f64)) -> String {
    format!("{:.2} ± {:.2} %", 100.0 * x, 100.0 * se)
}

/// A value's text, or a dash where there is none.
pub(crate) fn or_dash<T>(value: Option<T>, text: impl FnOnce(T) -> String) -> String {
    value.map_or("–".into(), text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_of_a_name_becomes_markup() {
        let rows = [vec!["<script>\"&".into()], vec!["1.5 ± 2".into()]];
        let table = table(&["a"], &rows).into_string();
        let escaped = "<td>&lt;script&gt;&quot;&amp;</td>";
        assert!(table.contains(escaped), "{table}");
        assert!(table.contains("<td class=\"n\">1.5 ± 2</td>"), "{table}");
    }
}
