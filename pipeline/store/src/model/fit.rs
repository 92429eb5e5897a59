//! One cell's fit on its own, before it becomes part of `model/`: a folder of two tables of one
//! row each, `weights.arrow` and `metrics.arrow`, beside the fit's course, `steps.arrow`. The
//! weights come last: a fit that has them is whole.

use super::{CellMetrics, path_in, read_batch, rows, source, weights};
use super::{write, write_models};
use crate::error::StoreError;
use crate::facts::{KEY_TASK, fact};
use crate::manifest::RunFacts;
use crate::schema::Table;
use rrf_field::columns::COUNT;
use rrf_field::model::CellModel;
use rrf_field::tree::Domain;
use std::path::Path;

const KEY_SPAN: &str = "rrf.span";

/// A cell's fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// The net.
    pub model: CellModel,
    /// How the fit went.
    pub metrics: CellMetrics,
    /// What the training rows span; `None` without rows.
    pub domain: Option<Domain>,
    /// Hash of what the fit was made from.
    pub task: String,
}

/// Writes a fit into a folder of its own.
///
/// # Errors
/// [`StoreError::Model`] for what could not be read back, [`StoreError::Io`].
pub fn write_fit(folder: &Path, fit: &Fit, facts: &RunFacts) -> Result<(), StoreError> {
    let task = [(KEY_TASK, fit.task.clone())];
    write(
        &path_in(folder, Table::Metrics),
        &[&fit.metrics],
        facts,
        &task,
    )?;
    let mut more = vec![(KEY_TASK, fit.task.clone())];
    more.extend(
        fit.domain
            .iter()
            .map(|domain| (KEY_SPAN, span_text(domain))),
    );
    let models = std::slice::from_ref(&fit.model);
    write_models(&path_in(folder, Table::Weights), models, facts, &more)
}

/// Hash of what the fit in a folder was made from; `None` where there is no whole fit.
///
/// # Errors
/// As [`read_fit`].
pub fn fit_task(folder: &Path, facts: &RunFacts) -> Result<Option<String>, StoreError> {
    if !path_in(folder, Table::Weights).exists() {
        return Ok(None);
    }
    // a fit that lost a table, or a bit of it, is none
    read_fit(folder, facts).map(|fit| Some(fit.task))
}

/// Reads a fit.
///
/// # Errors
/// As [`super::read_tree`].
pub fn read_fit(folder: &Path, facts: &RunFacts) -> Result<Fit, StoreError> {
    let path = path_in(folder, Table::Weights);
    let source = source(&path, Table::Weights);
    let batch = read_batch(&path, Table::Weights, facts)?;
    let span = fact(batch.schema_ref(), KEY_SPAN);
    let domain = match span.is_empty() {
        true => None,
        false => Some(
            span_value(&span)
                .ok_or_else(|| source.model("metadata".into(), "rrf.span is no list of numbers"))?,
        ),
    };
    let models = weights::from_rows(rows(&batch, &path)?, source)?;
    let task = fact(batch.schema_ref(), KEY_TASK);
    let metrics_path = path_in(folder, Table::Metrics);
    let metrics_batch = read_batch(&metrics_path, Table::Metrics, facts)?;
    if fact(metrics_batch.schema_ref(), KEY_TASK) != task {
        return Err(source.model("fit".into(), "weights and metrics are of different fits"));
    }
    let metrics: Vec<CellMetrics> = rows(&metrics_batch, &metrics_path)?;
    match (<[_; 1]>::try_from(models), <[_; 1]>::try_from(metrics)) {
        (Ok([model]), Ok([metrics])) if model.cell == metrics.cell_id => Ok(Fit {
            model,
            metrics,
            domain,
            task,
        }),
        _ => Err(source.model(
            "fit".into(),
            "weights and metrics are not one row each of the same cell",
        )),
    }
}

/// The bits of every bound, least values first: exact, whatever reads it.
fn span_text(domain: &Domain) -> String {
    let bounds = domain.minimum.iter().chain(&domain.maximum);
    let words: Vec<String> = bounds.map(|x| format!("{:08x}", x.to_bits())).collect();
    words.join(" ")
}

fn span_value(text: &str) -> Option<Domain> {
    let bounds: Option<Vec<f32>> = text
        .split(' ')
        .map(|word| u32::from_str_radix(word, 16).ok().map(f32::from_bits))
        .collect();
    let bounds = bounds.filter(|b| b.len() == 2 * COUNT)?;
    let (minimum, maximum) = bounds.split_at(COUNT);
    Some(Domain {
        minimum: minimum.try_into().ok()?,
        maximum: maximum.try_into().ok()?,
    })
}
