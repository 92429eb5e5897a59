//! Tables by name, and queries over them.

use crate::ReportError;
use polars::error::PolarsError;
use polars::frame::DataFrame;
use polars::prelude::LazyFrame;
use polars::sql::SQLContext;
use std::path::Path;

pub(super) type Result<T> = std::result::Result<T, ReportError>;

/// Tables by their names in SQL.
pub(super) type Tables = Vec<(&'static str, LazyFrame)>;

/// The result of a query over the tables.
pub(super) fn answer(tables: &Tables, query: &str) -> Result<DataFrame> {
    let mut context = SQLContext::new();
    for (name, table) in tables {
        context.register(name, table.clone());
    }
    let names: Vec<&str> = tables.iter().map(|(name, _)| *name).collect();
    let refused = |e: PolarsError| ReportError::Query {
        query: query.into(),
        reason: e.to_string(),
        tables: names.join(", "),
    };
    let answer = context.execute(query).map_err(refused)?;
    answer.collect().map_err(refused)
}

/// The error of a file that cannot be read.
pub(super) fn unread(path: &Path) -> impl Fn(std::io::Error) -> ReportError + '_ {
    move |e| ReportError::file(path, "be read", e)
}
