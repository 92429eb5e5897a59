//! The text of a schema file and what it becomes.

use super::{Column, KEY_SCHEMA, KEY_VERSION, TABLES, Table, TableSchema};
use arrow::datatypes::{DataType, Field, Schema};
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
    column: Vec<Column>,
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
    columns.extend(text.column);
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
        "uint32" => DataType::UInt32,
        "uint64" => DataType::UInt64,
        "float32" => DataType::Float32,
        "float64" => DataType::Float64,
        "utf8" => DataType::Utf8,
        _ => return None,
    })
}
