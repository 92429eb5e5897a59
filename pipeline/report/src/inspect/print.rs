//! Frames for people and for programs.

use super::glance::Section;
use super::tables::Result;
use polars::prelude::{AnyValue, DataFrame};
use serde_json::{Map, Value, json};
use std::path::Path;

/// One table.
pub(super) fn frame(frame: &DataFrame, as_json: bool) -> Result<()> {
    if as_json {
        println!("{:#}", rows(frame)?);
    } else {
        println!("{}", text(frame));
    }
    Ok(())
}

/// Every section under its heading.
pub(super) fn sections(path: &Path, sections: &[Section], as_json: bool) -> Result<()> {
    if as_json {
        let mut all = Map::new();
        for section in sections {
            all.insert(section.title.clone(), rows(&section.frame)?);
        }
        let page = json!({ "path": path.display().to_string(), "sections": all });
        println!("{page:#}");
        return Ok(());
    }
    println!("{}", path.display());
    for section in sections {
        println!("\n{}\n{}", section.title, text(&section.frame));
    }
    Ok(())
}

/// Columns side by side, numbers to the right.
fn text(frame: &DataFrame) -> String {
    let columns: Vec<Vec<String>> = (frame.columns().iter())
        .map(|column| {
            let cells = (0..column.len()).map(|row| match column.get(row) {
                Ok(value) => cell(&value),
                Err(_) => String::new(),
            });
            std::iter::once(column.name().to_string())
                .chain(cells)
                .collect()
        })
        .collect();
    let width = |c: &Vec<String>| c.iter().map(|t| t.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = columns.iter().map(width).collect();
    let mut out = String::new();
    for row in 0..=frame.height() {
        for (place, (column, width)) in columns.iter().zip(&widths).enumerate() {
            let cell = column.get(row).map_or("", String::as_str);
            let text = frame.columns()[place].dtype().is_string();
            if text {
                out += &format!("  {cell:<width$}");
            } else {
                out += &format!("  {cell:>width$}");
            }
        }
        out = out.trim_end().to_string() + "\n";
    }
    out
}

fn cell(value: &AnyValue) -> String {
    match value {
        AnyValue::Null => "–".into(),
        AnyValue::Float64(x) => number(*x),
        AnyValue::Float32(x) => number(f64::from(*x)),
        AnyValue::String(text) => (*text).to_string(),
        AnyValue::StringOwned(text) => text.to_string(),
        other => other.to_string(),
    }
}

/// Five digits that count.
fn number(x: f64) -> String {
    if x != 0.0 && (x.abs() < 1e-3 || x.abs() >= 1e7) {
        format!("{x:.4e}")
    } else {
        let digits = (4 - x.abs().max(1e-300).log10().floor() as i32).clamp(0, 7) as usize;
        format!("{x:.digits$}")
    }
}

/// A list of objects; what JSON has no number for (NaN, infinities) is a text.
fn rows(frame: &DataFrame) -> Result<Value> {
    let mut rows = Vec::with_capacity(frame.height());
    for at in 0..frame.height() {
        let mut row = Map::new();
        for column in frame.columns() {
            row.insert(column.name().to_string(), value(&column.get(at)?));
        }
        rows.push(Value::Object(row));
    }
    Ok(Value::Array(rows))
}

fn value(value: &AnyValue) -> Value {
    let real = |x: f64| serde_json::Number::from_f64(x).map_or(json!(x.to_string()), Value::Number);
    match value {
        AnyValue::Null => Value::Null,
        AnyValue::Boolean(b) => json!(b),
        AnyValue::Int8(x) => json!(x),
        AnyValue::Int16(x) => json!(x),
        AnyValue::Int32(x) => json!(x),
        AnyValue::Int64(x) => json!(x),
        AnyValue::UInt8(x) => json!(x),
        AnyValue::UInt16(x) => json!(x),
        AnyValue::UInt32(x) => json!(x),
        AnyValue::UInt64(x) => json!(x),
        AnyValue::Float32(x) => real(f64::from(*x)),
        AnyValue::Float64(x) => real(*x),
        AnyValue::String(text) => json!(text),
        AnyValue::StringOwned(text) => json!(text.as_str()),
        AnyValue::List(series) => {
            let items = series.iter().map(|item| self::value(&item));
            Value::Array(items.collect())
        }
        other => json!(other.to_string()),
    }
}
