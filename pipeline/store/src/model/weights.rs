//! `model/weights.arrow`.

use super::lists;
use crate::columns::Source;
use crate::error::StoreError;
use crate::schema::{self, Table};
use arrow::array::{ArrayRef, AsArray, BooleanArray, ListArray, RecordBatch};
use arrow::array::{StringArray, UInt32Array};
use arrow::datatypes::{Float32Type, UInt32Type};
use rrf_field::model::{CellModel, INPUTS, KINDS, Kind};
use rrf_field::net::Shape;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

const CELL_ID: &str = "cell_id";
const KIND: &str = "kind";
const NAMES: &str = "inputs";
const INPUT_OFFSET: &str = "input_offset";
const INPUT_SCALE: &str = "input_scale";
const LAYERS: &str = "layers";
const WEIGHTS: &str = "weights";
const OUTPUT_SCALE: &str = "output_scale";
const OUTPUT_OFFSET: &str = "output_offset";
const DIVIDE_BASE: &str = "divide_base";
const EXPONENTIAL: &str = "exponential";

pub(super) fn to_batch(cells: &[CellModel], path: &Path) -> Result<RecordBatch, StoreError> {
    let source = super::source(path, Table::Weights);
    let mut cells: Vec<&CellModel> = cells.iter().collect();
    cells.sort_by_key(|cell| cell.cell);
    validate(&cells, &source)?;
    let floats = |get: fn(&CellModel) -> &[f32]| {
        lists::numbers::<Float32Type>(cells.iter().map(|cell| Some(get(cell))))
    };
    let input_names = cells.iter().map(|cell| {
        let inputs = cell.inputs.iter();
        inputs
            .filter_map(|&input| INPUTS.get(input as usize).copied())
            .collect()
    });
    let layers: Vec<Vec<u32>> = cells.iter().map(|cell| sizes(&cell.shape)).collect();
    let layers = lists::numbers::<UInt32Type>(layers.iter().map(|sizes| Some(sizes.as_slice())));
    let ids = UInt32Array::from_iter_values(cells.iter().map(|cell| cell.cell));
    let kinds = StringArray::from_iter_values(cells.iter().map(|cell| cell.kind.name()));
    let divide: BooleanArray = cells.iter().map(|cell| Some(cell.divide_base)).collect();
    let exponential: BooleanArray = cells.iter().map(|cell| Some(cell.exponential)).collect();
    let arrays: BTreeMap<&str, ArrayRef> = BTreeMap::from([
        (CELL_ID, Arc::new(ids) as _),
        (KIND, Arc::new(kinds) as _),
        (NAMES, lists::names(input_names)),
        (INPUT_OFFSET, floats(|cell| &cell.input_offset)),
        (INPUT_SCALE, floats(|cell| &cell.input_scale)),
        (LAYERS, layers),
        (WEIGHTS, floats(|cell| &cell.weights)),
        (OUTPUT_SCALE, floats(|cell| &cell.output_scale)),
        (OUTPUT_OFFSET, floats(|cell| &cell.output_offset)),
        (DIVIDE_BASE, Arc::new(divide) as _),
        (EXPONENTIAL, Arc::new(exponential) as _),
    ]);
    schema::table(Table::Weights)?.batch(arrays)
}

pub(super) fn from_batch(
    batch: &RecordBatch,
    source: Source,
) -> Result<Vec<CellModel>, StoreError> {
    let rows = Rows::new(batch, source)?;
    let cells = (0..batch.num_rows())
        .map(|row| rows.cell(row))
        .collect::<Result<Vec<_>, _>>()?;
    validate(&cells.iter().collect::<Vec<_>>(), &source)?;
    Ok(cells)
}

/// The table's columns, found and typed.
struct Rows<'a> {
    source: Source<'a>,
    cell_id: &'a [u32],
    kind: &'a StringArray,
    lists: BTreeMap<&'static str, &'a ListArray>,
    divide_base: &'a BooleanArray,
    exponential: &'a BooleanArray,
}

impl<'a> Rows<'a> {
    fn new(batch: &'a RecordBatch, source: Source<'a>) -> Result<Rows<'a>, StoreError> {
        let names = [
            NAMES,
            INPUT_OFFSET,
            INPUT_SCALE,
            LAYERS,
            WEIGHTS,
            OUTPUT_SCALE,
            OUTPUT_OFFSET,
        ];
        let mut columns = BTreeMap::new();
        for name in names {
            columns.insert(name, lists::column(&source, batch, name)?);
        }
        Ok(Rows {
            source,
            cell_id: source.values::<UInt32Type>(batch, CELL_ID)?,
            kind: texts(batch, &source, KIND)?,
            lists: columns,
            divide_base: flags(batch, &source, DIVIDE_BASE)?,
            exponential: flags(batch, &source, EXPONENTIAL)?,
        })
    }

    fn cell(&self, row: usize) -> Result<CellModel, StoreError> {
        let cell = self.cell_id.get(row).copied().unwrap_or(u32::MAX);
        let layers: Vec<u32> = self.numbers::<UInt32Type>(LAYERS, row)?;
        Ok(CellModel {
            cell,
            kind: self.kind(cell, row)?,
            inputs: self.inputs(cell, row)?,
            input_offset: self.numbers::<Float32Type>(INPUT_OFFSET, row)?,
            input_scale: self.numbers::<Float32Type>(INPUT_SCALE, row)?,
            shape: Shape {
                sizes: layers.into_iter().map(|size| size as usize).collect(),
            },
            weights: self.numbers::<Float32Type>(WEIGHTS, row)?,
            output_scale: self.rgb(cell, OUTPUT_SCALE, row)?,
            output_offset: self.rgb(cell, OUTPUT_OFFSET, row)?,
            divide_base: self.divide_base.value(row),
            exponential: self.exponential.value(row),
        })
    }

    fn kind(&self, cell: u32, row: usize) -> Result<Kind, StoreError> {
        let name = self.kind.value(row);
        Kind::of_name(name).ok_or_else(|| {
            let known = KINDS.map(Kind::name).join(", ");
            let reason = format!("kind {name:?} is not known; known are {known}");
            self.source.model(format!("cell {cell}"), reason)
        })
    }

    fn list(&self, name: &'static str) -> Result<&'a ListArray, StoreError> {
        let missing = || {
            self.source
                .schema_error(format!("column {name} is missing"))
        };
        self.lists.get(name).copied().ok_or_else(missing)
    }

    fn numbers<T: arrow::array::ArrowPrimitiveType>(
        &self,
        name: &'static str,
        row: usize,
    ) -> Result<Vec<T::Native>, StoreError> {
        let numbers = lists::row::<T>(&self.source, self.list(name)?, name, row)?;
        numbers.ok_or_else(|| self.source.null(name, row))
    }

    fn rgb(&self, cell: u32, name: &'static str, row: usize) -> Result<[f32; 3], StoreError> {
        let numbers = self.numbers::<Float32Type>(name, row)?;
        let wrong = |v: Vec<f32>| format!("{name} has {} numbers, not 3", v.len());
        <[f32; 3]>::try_from(numbers)
            .map_err(|v| self.source.model(format!("cell {cell}"), wrong(v)))
    }

    fn inputs(&self, cell: u32, row: usize) -> Result<Vec<u8>, StoreError> {
        let names = lists::row_of_names(&self.source, self.list(NAMES)?, NAMES, row)?;
        let place = |name: &String| {
            let place = INPUTS.iter().position(|known| known == name);
            place
                .and_then(|place| u8::try_from(place).ok())
                .ok_or_else(|| {
                    let reason = format!("input {name:?} is not known");
                    self.source.model(format!("cell {cell}"), reason)
                })
        };
        names.iter().map(place).collect()
    }
}

/// A column of booleans without nulls.
fn flags<'a>(
    batch: &'a RecordBatch,
    source: &Source,
    name: &'static str,
) -> Result<&'a BooleanArray, StoreError> {
    let column = source.array(batch, name)?;
    source.no_null(column, name)?;
    column
        .as_boolean_opt()
        .ok_or_else(|| source.schema_error(format!("column {name}: expected bool")))
}

/// A column of texts without nulls.
fn texts<'a>(
    batch: &'a RecordBatch,
    source: &Source,
    name: &'static str,
) -> Result<&'a StringArray, StoreError> {
    let column = source.array(batch, name)?;
    source.no_null(column, name)?;
    column
        .as_string_opt()
        .ok_or_else(|| source.schema_error(format!("column {name}: expected utf8")))
}

/// Models that can be evaluated: ids ascend, every length fits the shape, every number is finite.
fn validate(cells: &[&CellModel], source: &Source) -> Result<(), StoreError> {
    for pair in cells.windows(2) {
        if let [a, b] = pair
            && a.cell >= b.cell
        {
            let reason = format!("comes after cell {}; ids must ascend", a.cell);
            return Err(source.model(format!("cell {}", b.cell), reason));
        }
    }
    for cell in cells {
        if let Some(reason) = fault(cell) {
            return Err(source.model(format!("cell {}", cell.cell), reason));
        }
    }
    Ok(())
}

fn fault(cell: &CellModel) -> Option<String> {
    let sizes = &cell.shape.sizes;
    let count = cell.inputs.len();
    if let Some(input) = cell.inputs.iter().find(|&&i| i as usize >= INPUTS.len()) {
        return Some(format!("input {input} is not known"));
    }
    // a cell that is one colour all over has a net of no inputs: its mean
    let hidden = sizes.get(1..).unwrap_or_default();
    if cell.kind.is_net() && (sizes.len() < 2 || hidden.contains(&0) || sizes.last() != Some(&3)) {
        return Some(format!("layers {sizes:?} are not inputs, hidden units, 3"));
    }
    let lengths = [count, cell.input_offset.len(), cell.input_scale.len()];
    if sizes.first() != Some(&count) || lengths != [count; 3] {
        return Some(format!(
            "{lengths:?} inputs, offsets and scales for layers {sizes:?}"
        ));
    }
    let weights = cell.kind.weights(sizes);
    if weights != Some(cell.weights.len()) {
        let (found, kind) = (cell.weights.len(), cell.kind.name());
        return Some(format!(
            "{found} weights, layers {sizes:?} of kind {kind} have {weights:?}"
        ));
    }
    let parts: [(&str, &[f32]); 5] = [
        (INPUT_OFFSET, &cell.input_offset),
        (INPUT_SCALE, &cell.input_scale),
        (WEIGHTS, &cell.weights),
        (OUTPUT_SCALE, &cell.output_scale),
        (OUTPUT_OFFSET, &cell.output_offset),
    ];
    let bad = parts.iter().find(|(_, x)| !x.iter().all(|x| x.is_finite()));
    bad.map(|(name, _)| format!("{name} holds a number that is not finite"))
}

fn sizes(shape: &Shape) -> Vec<u32> {
    let sizes = shape.sizes.iter();
    sizes
        .map(|&size| u32::try_from(size).unwrap_or(u32::MAX))
        .collect()
}
