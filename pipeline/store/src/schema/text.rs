//! The text of a schema file and what it becomes.

use super::contract::{Column, KEY_SCHEMA, KEY_VERSION, TableSchema};
use super::tables::{TABLES, Table};
use arrow::datatypes::{DataType, Field, Schema};
use rrf_field::inputs::{INPUTS, Input, RAW};
use std::collections::HashMap;
use std::sync::Arc;

/// A file of `schemas/` as written.
#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Text {
    name: String,
    version: u32,
    format: String,
    file: String,
    extends: Option<String>,
    doc: String,
    column: Vec<Entry>,
}

/// A column, or in its place the raw columns of a row, which `rrf_field::inputs` describes.
#[derive(Debug, serde::Deserialize)]
#[serde(untagged)]
enum Entry {
    Column(Column),
    Raw { raw: Raw },
}

#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
enum Raw {
    /// All of them.
    All,
    /// Those in the world frame: point, normal, viewer and light.
    World,
}

/// Reads and lowers one schema file.
pub(super) fn parse(table: Table) -> Result<TableSchema, String> {
    let text: Text = toml::from_str(table.text()).map_err(|e| e.to_string())?;
    if text.name != table.name() {
        return Err(format!("its name is {}", text.name));
    }
    let mut columns = match &text.extends {
        None => Vec::new(),
        Some(base) => {
            let base = TABLES
                .into_iter()
                .find(|t| t.name() == base && *t != table)
                .ok_or_else(|| format!("extends {base}, which is not known"))?;
            parse(base)?.columns
        }
    };
    let inherited = columns.len();
    for entry in text.column {
        match entry {
            Entry::Column(column) => columns.push(column),
            Entry::Raw { raw } => columns.extend(raw_columns(raw)),
        }
    }
    let mut fields = Vec::with_capacity(columns.len());
    for (i, column) in columns.iter().enumerate() {
        if columns.iter().take(i).any(|c| c.name == column.name) {
            return Err(format!("column {} is there twice", column.name));
        }
        fields.push(field(column)?);
    }
    let arrow = Schema::new_with_metadata(
        fields,
        HashMap::from([
            (KEY_SCHEMA.to_string(), table.name().to_string()),
            (KEY_VERSION.to_string(), text.version.to_string()),
        ]),
    );
    Ok(TableSchema {
        table,
        version: text.version,
        format: text.format,
        file: text.file,
        doc: text.doc,
        columns,
        inherited,
        arrow: Arc::new(arrow),
    })
}

/// The raw columns of a row.
fn raw_columns(which: Raw) -> impl Iterator<Item = Column> {
    let wanted = move |input: &&Input| which == Raw::All || input.frame == "world";
    INPUTS[..RAW].iter().filter(wanted).map(|input| Column {
        name: input.name.into(),
        type_name: "float32".into(),
        unit: input.unit.into(),
        frame: input.frame.into(),
        nullable: false,
        meaning: input.meaning.into(),
    })
}

fn field(column: &Column) -> Result<Field, String> {
    let data_type = data_type(&column.type_name)
        .ok_or_else(|| format!("column {}: unknown type {}", column.name, column.type_name))?;
    let metadata = [
        ("unit", &column.unit),
        ("frame", &column.frame),
        ("meaning", &column.meaning),
    ]
    .map(|(key, value)| (key.to_string(), value.clone()));
    Ok(Field::new(&column.name, data_type, column.nullable)
        .with_metadata(metadata.into_iter().collect::<HashMap<_, _>>()))
}

fn data_type(name: &str) -> Option<DataType> {
    if let Some(item) = name
        .strip_prefix("list<")
        .and_then(|rest| rest.strip_suffix('>'))
    {
        return Some(DataType::new_list(data_type(item)?, false));
    }
    Some(match name {
        "bool" => DataType::Boolean,
        "int8" => DataType::Int8,
        "int16" => DataType::Int16,
        "int32" => DataType::Int32,
        "uint32" => DataType::UInt32,
        "uint64" => DataType::UInt64,
        "float32" => DataType::Float32,
        "float64" => DataType::Float64,
        "utf8" => DataType::Utf8,
        _ => return None,
    })
}
