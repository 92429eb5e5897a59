//! `rrf inspect`: tables at a glance, by polars.

mod glance;
mod open;
mod print;

use crate::BadInput;
use crate::args::InspectArgs;
use polars::prelude::LazyFrame;
use polars::sql::SQLContext;

/// Tables by their names in SQL.
pub(crate) type Tables = Vec<(&'static str, LazyFrame)>;

/// Answers the query, or shows every table. Files are not trusted: a decoder that gives up on
/// one by a panic makes it bad input like any other.
pub(crate) fn run(args: &InspectArgs) -> anyhow::Result<()> {
    let report = std::panic::take_hook();
    std::panic::set_hook(Box::new(|_| {}));
    let done = std::panic::catch_unwind(|| answer(args));
    std::panic::set_hook(report);
    done.unwrap_or_else(|panic| {
        let said = (panic.downcast_ref::<String>().map(String::as_str))
            .or_else(|| panic.downcast_ref::<&str>().copied());
        Err(BadInput(format!(
            "{}: polars gave up: {}. The file is damaged (make it again), or polars cannot do what \
             was asked of it",
            args.path.display(),
            said.unwrap_or("a decoder gave up")
        ))
        .into())
    })
}

fn answer(args: &InspectArgs) -> anyhow::Result<()> {
    let tables = open::open(&args.path)?;
    if let Some(query) = &args.sql {
        let frame = sql(&tables, query)?;
        return print::frame(&frame, args.json);
    }
    let sections = glance::sections(&args.path, &tables)?;
    print::sections(&args.path, &sections, args.json)
}

/// The result of a query over the tables.
pub(crate) fn sql(tables: &Tables, query: &str) -> anyhow::Result<polars::frame::DataFrame> {
    let mut context = SQLContext::new();
    for (name, table) in tables {
        context.register(name, table.clone());
    }
    let names: Vec<&str> = tables.iter().map(|(name, _)| *name).collect();
    let refused = |e: polars::error::PolarsError| {
        BadInput(format!("{query}: {e} (tables: {})", names.join(", ")))
    };
    let answer = context.execute(query).map_err(refused)?;
    Ok(answer.collect().map_err(refused)?)
}
