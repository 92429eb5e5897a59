//! `model/weights.arrow`.

use crate::error::StoreError;
use crate::table::Source;
use crate::table_row;
use rrf_field::inputs::{self, NAMES};
use rrf_field::model::{CellModel, Kind, MODEL_KINDS};
use rrf_field::net::Shape;

table_row! {
    /// A cell's model, as in `schemas/weights.toml`.
    #[derive(Clone, Debug)]
    pub(super) struct Row of Weights {
        cell_id: u32,
        kind: String,
        inputs: Vec<String>,
        input_offset: Vec<f32>,
        input_scale: Vec<f32>,
        layers: Vec<u32>,
        weights: Vec<f32>,
        output_scale: Vec<f32>,
        output_offset: Vec<f32>,
        divide_base: bool,
        exponential: bool,
    }
}

pub(super) fn to_rows(cells: &[CellModel], source: Source) -> Result<Vec<Row>, StoreError> {
    let mut cells = cells.to_vec();
    cells.sort_by_key(|cell| cell.cell);
    validate(&cells, source)?;
    Ok(cells.into_iter().map(row).collect())
}

pub(super) fn from_rows(rows: Vec<Row>, source: Source) -> Result<Vec<CellModel>, StoreError> {
    let model = |row: Row| {
        let place = format!("cell {}", row.cell_id);
        model(row).map_err(|reason| source.model(place, reason))
    };
    let cells = rows.into_iter().map(model).collect::<Result<Vec<_>, _>>()?;
    validate(&cells, source)?;
    Ok(cells)
}

fn row(cell: CellModel) -> Row {
    let inputs = cell.inputs.iter();
    let sizes = cell.shape.sizes.iter();
    Row {
        cell_id: cell.cell,
        kind: cell.kind.name().into(),
        inputs: inputs
            .map(|&input| NAMES[usize::from(input)].into())
            .collect(),
        input_offset: cell.input_offset,
        input_scale: cell.input_scale,
        layers: sizes
            .map(|&size| u32::try_from(size).unwrap_or(u32::MAX))
            .collect(),
        weights: cell.weights,
        output_scale: cell.output_scale.into(),
        output_offset: cell.output_offset.into(),
        divide_base: cell.divide_base,
        exponential: cell.exponential,
    }
}

fn model(row: Row) -> Result<CellModel, String> {
    let kind = Kind::of_name(&row.kind).ok_or_else(|| {
        let known = MODEL_KINDS.map(Kind::name).join(", ");
        format!("kind {:?} is not known; known are {known}", row.kind)
    })?;
    let input =
        |name: &String| inputs::place(name).ok_or_else(|| format!("input {name:?} is not known"));
    let rgb = |name: &str, numbers: Vec<f32>| {
        let wrong = |numbers: Vec<f32>| format!("{name} has {} numbers, not 3", numbers.len());
        <[f32; 3]>::try_from(numbers).map_err(wrong)
    };
    Ok(CellModel {
        cell: row.cell_id,
        kind,
        inputs: row.inputs.iter().map(input).collect::<Result<_, _>>()?,
        input_offset: row.input_offset,
        input_scale: row.input_scale,
        shape: Shape {
            sizes: row.layers.into_iter().map(|size| size as usize).collect(),
        },
        weights: row.weights,
        output_scale: rgb("output_scale", row.output_scale)?,
        output_offset: rgb("output_offset", row.output_offset)?,
        divide_base: row.divide_base,
        exponential: row.exponential,
    })
}

/// Models that can be evaluated, by ascending cell id.
fn validate(cells: &[CellModel], source: Source) -> Result<(), StoreError> {
    let repeated = cells.windows(2).find(|pair| pair[0].cell >= pair[1].cell);
    if let Some([a, b]) = repeated {
        let reason = format!("comes after cell {}; ids must ascend", a.cell);
        return Err(source.model(format!("cell {}", b.cell), reason));
    }
    let mut faults = cells
        .iter()
        .filter_map(|cell| Some((cell.cell, cell.fault()?)));
    match faults.next() {
        Some((cell, reason)) => Err(source.model(format!("cell {cell}"), reason)),
        None => Ok(()),
    }
}
