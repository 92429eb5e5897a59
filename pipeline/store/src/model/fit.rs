//! One cell's fit on its own, before it becomes part of `model/`: a folder of two tables of one
//! row each, `weights.arrow` and `metrics.arrow`, beside the fit's course, `steps.arrow`. The
//! weights come last: a fit that has them is whole.

use super::{CellMetrics, Domain, metrics, read, source, weights, write};
use crate::error::StoreError;
use crate::manifest::RunFacts;
use crate::schema::Table;
use arrow::array::RecordBatch;
use rrf_field::columns::COUNT;
use rrf_field::model::CellModel;
use std::path::{Path, PathBuf};

const KEY_TASK: &str = "rrf.task";
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
    let path = table_path(folder, Table::Metrics);
    let batch = metrics::to_batch(std::slice::from_ref(&fit.metrics))?;
    write(&path, Table::Metrics, batch, facts)?;
    let path = table_path(folder, Table::Weights);
    let mut batch = weights::to_batch(std::slice::from_ref(&fit.model), &path)?;
    let metadata = batch.schema_metadata_mut();
    metadata.insert(KEY_TASK.to_string(), fit.task.clone());
    if let Some(domain) = &fit.domain {
        metadata.insert(KEY_SPAN.to_string(), span_text(domain));
    }
    write(&path, Table::Weights, batch, facts)
}

/// Hash of what the fit in a folder was made from; `None` where there is no whole fit.
///
/// # Errors
/// As [`read_fit`].
pub fn fit_task(folder: &Path, facts: &RunFacts) -> Result<Option<String>, StoreError> {
    if !table_path(folder, Table::Weights).exists() {
        return Ok(None);
    }
    Ok(Some(fact(&weights_batch(folder, facts)?, KEY_TASK)))
}

/// Reads a fit.
///
/// # Errors
/// As [`super::read_tree`].
pub fn read_fit(folder: &Path, facts: &RunFacts) -> Result<Fit, StoreError> {
    let path = table_path(folder, Table::Weights);
    let batch = weights_batch(folder, facts)?;
    let span = fact(&batch, KEY_SPAN);
    let domain = match span.is_empty() {
        true => None,
        false => Some(span_value(&span).ok_or_else(|| {
            source(&path, Table::Weights).model("metadata".into(), "rrf.span is no list of numbers")
        })?),
    };
    let task = fact(&batch, KEY_TASK);
    let models = weights::from_batch(&batch, source(&path, Table::Weights))?;
    let metrics_path = table_path(folder, Table::Metrics);
    let metrics = metrics::from_batch(
        &read(&metrics_path, Table::Metrics, facts)?,
        source(&metrics_path, Table::Metrics),
    )?;
    match (<[_; 1]>::try_from(models), <[_; 1]>::try_from(metrics)) {
        (Ok([model]), Ok([metrics])) if model.cell == metrics.cell_id => Ok(Fit {
            model,
            metrics,
            domain,
            task,
        }),
        _ => Err(source(&path, Table::Weights).model(
            "fit".into(),
            "weights and metrics are not one row each of the same cell",
        )),
    }
}

fn weights_batch(folder: &Path, facts: &RunFacts) -> Result<RecordBatch, StoreError> {
    read(&table_path(folder, Table::Weights), Table::Weights, facts)
}

pub(super) fn table_path(folder: &Path, table: Table) -> PathBuf {
    folder.join(format!("{}.arrow", table.name()))
}

fn fact(batch: &RecordBatch, key: &str) -> String {
    let schema = batch.schema();
    schema.metadata().get(key).cloned().unwrap_or_default()
}

/// The bits of every bound, least values first: exact, whatever reads it.
fn span_text(domain: &Domain) -> String {
    let bounds = domain.min.iter().chain(&domain.max);
    let words: Vec<String> = bounds.map(|x| format!("{:08x}", x.to_bits())).collect();
    words.join(" ")
}

fn span_value(text: &str) -> Option<Domain> {
    let bounds: Option<Vec<f32>> = text
        .split(' ')
        .map(|word| u32::from_str_radix(word, 16).ok().map(f32::from_bits))
        .collect();
    let bounds = bounds.filter(|b| b.len() == 2 * COUNT)?;
    let (min, max) = bounds.split_at(COUNT);
    Some(Domain {
        min: min.try_into().ok()?,
        max: max.try_into().ok()?,
    })
}
