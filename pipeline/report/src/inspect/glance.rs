//! A summary of each table.

use super::tables::{Result, Tables, answer, unread};
use crate::ReportError;
use polars::prelude::{Column, DataFrame, DataType, IntoColumn, IntoLazy, NamedFrom, Series};
use std::path::Path;

/// A heading and a table.
pub(super) struct Section {
    pub(super) title: String,
    pub(super) frame: DataFrame,
}

/// A kind of table, known by a column that no other has, and a question worth asking of it, where
/// `self` stands for its name.
struct Question {
    column: &'static str,
    title: &'static str,
    query: &'static str,
}

const QUESTIONS: [Question; 11] = [
    Question {
        column: "y0_r",
        title: "cells",
        query: "SELECT COUNT(*) AS cells, SUM(n) AS rows, MIN(n) AS fewest, MAX(n) AS most \
                FROM (SELECT cell_id, COUNT(*) AS n FROM self GROUP BY cell_id) AS c",
    },
    Question {
        column: "y0_r",
        title: "noise of a row, from its two halves, and mean of all rows [W/(sr m^2)]",
        query: "SELECT SQRT(AVG((y0_r-y1_r)*(y0_r-y1_r) + (y0_g-y1_g)*(y0_g-y1_g) + \
                (y0_b-y1_b)*(y0_b-y1_b)) / 12.0) AS standard_error, \
                AVG(y0_r + y0_g + y0_b + y1_r + y1_g + y1_b) / 6.0 AS mean_radiance FROM self",
    },
    Question {
        column: "stop_reason",
        title: "whole",
        query: "SELECT COUNT(*) AS cells, SUM(rows) AS rows, SUM(weights) AS weights, \
                SUM(quarantined_rows) AS quarantined, \
                SQRT(GREATEST(SUM(relative_square_error_validation * validation_rows) / \
                SUM(validation_rows), 0.0)) AS held_out_error, AVG(iterations) AS iterations FROM self",
    },
    Question {
        column: "stop_reason",
        title: "worst cells",
        query: "SELECT cell_id, rows, relative_error_validation, relative_error_validation_se, \
                relative_error_train, noise, weights, effective_parameters, stop_reason FROM self \
                ORDER BY relative_error_validation DESC LIMIT 8",
    },
    Question {
        column: "stop_reason",
        title: "why fits stopped",
        query: "SELECT stop_reason, COUNT(*) AS cells FROM self GROUP BY stop_reason \
                ORDER BY cells DESC, stop_reason",
    },
    Question {
        column: "seam_jump",
        title: "where cells meet, relative: jumps between nets, change of a net over a tenth of its cell \
                (root mean squares; medians of the cells' medians)",
        query: "SELECT SUM(seam_rows) AS rows, \
                SQRT(SUM(seam_jump * seam_jump * seam_rows) / NULLIF(SUM(seam_rows), 0)) AS jump, \
                MEDIAN(seam_jump_median) AS jump_median, \
                SQRT(SUM(seam_change * seam_change * seam_rows) / NULLIF(SUM(seam_rows), 0)) AS change, \
                MEDIAN(seam_change_median) AS change_median FROM self",
    },
    Question {
        column: "trusted_share",
        title: "error on test rows",
        query: "SELECT relative_error, relative_error_se, median_error, percentile_95, worst_share, \
                trusted_share, trusted_error, test_rows, lights FROM self",
    },
    Question {
        column: "judged",
        title: "whole",
        query: "SELECT COUNT(*) AS cells, SUM(rows) AS rows, SUM(judged) AS held_out_rows, \
                SQRT(SUM(CAST(error AS DOUBLE) * error * judged) / \
                SUM(CASE WHEN error IS NULL THEN 0 ELSE judged END)) AS held_out_error, \
                AVG(rank) AS coefficients, MAX(rank) AS most_coefficients FROM self",
    },
    Question {
        column: "judged",
        title: "worst cells",
        query: "SELECT cell_id, error, rows, judged, rank FROM self WHERE error IS NOT NULL \
                ORDER BY error DESC LIMIT 8",
    },
    Question {
        column: "turns",
        title: "fits",
        query: "SELECT part, kind, COUNT(*) AS cells FROM self GROUP BY part, kind ORDER BY part, kind",
    },
    Question {
        column: "frame_error",
        title: "settings over their seeds",
        query: "SELECT method, setting, COUNT(*) AS seeds, AVG(bake_seconds) AS bake_seconds, \
                AVG(frame_seconds) AS frame_seconds, AVG(model_bytes) AS model_bytes, \
                AVG(held_out_error) AS held_out_error, AVG(frame_error) AS frame_error, \
                STDDEV(frame_error) AS deviation FROM self GROUP BY method, setting \
                ORDER BY frame_error",
    },
];

/// Sizes on disk, then each table's columns and figures.
pub(super) fn sections(path: &Path, tables: &Tables) -> Result<Vec<Section>> {
    let mut sections = vec![Section {
        title: "bytes".into(),
        frame: sizes(path)?,
    }];
    for (name, table) in tables {
        let refused = |e| ReportError::input(path, format!("table {name}: {e}"));
        let frame = table.clone().collect().map_err(refused)?;
        sections.push(Section {
            title: format!("{name}: {} rows, {} columns", frame.height(), frame.width()),
            frame: columns(&frame)?,
        });
        let here = |q: &&Question| frame.columns().iter().any(|c| c.name() == q.column);
        let alone: Tables = vec![("self", frame.clone().lazy())];
        for question in QUESTIONS.iter().filter(here) {
            sections.push(Section {
                title: format!("{name}: {}", question.title),
                frame: answer(&alone, question.query)?,
            });
        }
    }
    Ok(sections)
}

/// Type, range, nulls and NaNs of every column; no range for texts and lists.
fn columns(frame: &DataFrame) -> Result<DataFrame> {
    let (mut names, mut types, mut nulls, mut nans) = (vec![], vec![], vec![], vec![]);
    let (mut least, mut greatest, mut mean) = (vec![], vec![], vec![]);
    for column in frame.columns() {
        let numeric = column.dtype().is_primitive_numeric();
        names.push(column.name().to_string());
        types.push(column.dtype().to_string());
        nulls.push(column.null_count() as u64);
        nans.push(nan_count(column)?);
        let values = if numeric {
            Some(column.cast(&DataType::Float64)?)
        } else {
            None
        };
        let values = values.as_ref().map(|c| c.f64()).transpose()?;
        let of = |f: fn(&polars::prelude::Float64Chunked) -> Option<f64>| values.and_then(f);
        use polars::prelude::ChunkAgg;
        least.push(of(|c| c.min()));
        greatest.push(of(|c| c.max()));
        mean.push(of(|c| c.mean()));
    }
    Ok(DataFrame::new_infer_height(vec![
        Series::new("column".into(), names).into_column(),
        Series::new("type".into(), types).into_column(),
        Series::new("least".into(), least).into_column(),
        Series::new("mean".into(), mean).into_column(),
        Series::new("greatest".into(), greatest).into_column(),
        Series::new("nulls".into(), nulls).into_column(),
        Series::new("nans".into(), nans).into_column(),
    ])?)
}

fn nan_count(column: &Column) -> Result<u64> {
    if !column.dtype().is_float() {
        return Ok(0);
    }
    Ok(u64::from(column.is_nan()?.sum().unwrap_or(0)))
}

/// Bytes of the file, or of what lies in each part of a folder.
fn sizes(path: &Path) -> Result<DataFrame> {
    let mut parts: Vec<(String, u64)> = Vec::new();
    if path.is_dir() {
        for entry in std::fs::read_dir(path).map_err(unread(path))? {
            let entry = entry.map_err(unread(path))?;
            let name = entry.file_name().to_string_lossy().into_owned();
            parts.push((name, bytes(&entry.path())?));
        }
        parts.sort();
    } else {
        parts.push((path.display().to_string(), bytes(path)?));
    }
    let (names, bytes): (Vec<String>, Vec<u64>) = parts.into_iter().unzip();
    Ok(DataFrame::new_infer_height(vec![
        Series::new("part".into(), names).into_column(),
        Series::new("bytes".into(), bytes).into_column(),
    ])?)
}

fn bytes(path: &Path) -> Result<u64> {
    if !path.is_dir() {
        return Ok(std::fs::symlink_metadata(path).map_err(unread(path))?.len());
    }
    let mut sum = 0;
    for entry in std::fs::read_dir(path).map_err(unread(path))? {
        sum += bytes(&entry.map_err(unread(path))?.path())?;
    }
    Ok(sum)
}
