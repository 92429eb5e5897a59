//! Parquet tables as columns of numbers.

use arrow::array::{Array, ArrayRef, AsArray, Float32Array, RecordBatch, StringArray};
use arrow::compute::{cast, concat_batches};
use arrow::datatypes::{DataType, Field, Float64Type, Schema};
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use std::fs::File;
use std::sync::Arc;

/// The geometry columns of a points table.
pub const GEOMETRY: [&str; 12] = [
    "px", "py", "pz", "nx", "ny", "nz", "vx", "vy", "vz", "lx", "ly", "lz",
];

/// A whole table.
pub struct Table(RecordBatch);

impl Table {
    pub fn read(path: &str) -> Table {
        let reader = File::open(path)
            .map_err(parquet::errors::ParquetError::from)
            .and_then(ParquetRecordBatchReaderBuilder::try_new)
            .unwrap_or_else(|e| panic!("{path}: {e}"));
        let schema = reader.schema().clone();
        let batches: Vec<RecordBatch> = reader
            .build()
            .expect("a reader")
            .collect::<Result<_, _>>()
            .unwrap_or_else(|e| panic!("{path}: {e}"));
        Table(concat_batches(&schema, &batches).expect("batches of one schema"))
    }

    pub fn rows(&self) -> usize {
        self.0.num_rows()
    }

    pub fn has(&self, name: &str) -> bool {
        self.0.column_by_name(name).is_some()
    }

    fn column(&self, name: &str) -> &ArrayRef {
        self.0
            .column_by_name(name)
            .unwrap_or_else(|| panic!("no column {name}"))
    }

    /// A column of numbers without nulls.
    pub fn numbers(&self, name: &str) -> Vec<f64> {
        let column = cast(self.column(name), &DataType::Float64).expect("numbers");
        assert_eq!(column.null_count(), 0, "{name}");
        column.as_primitive::<Float64Type>().values().to_vec()
    }

    /// A column of names.
    pub fn names(&self, name: &str) -> Vec<String> {
        let column = cast(self.column(name), &DataType::Utf8).expect("names");
        let names = column.as_string::<i32>().iter();
        names.map(|x| x.expect("no null").to_string()).collect()
    }

    /// The columns `r g b` with an ending, row by row.
    pub fn rgb(&self, ending: &str) -> Vec<[f64; 3]> {
        let [r, g, b] = ["r", "g", "b"].map(|c| self.numbers(&format!("{c}{ending}")));
        let rows = r.iter().zip(&g).zip(&b);
        rows.map(|((&r, &g), &b)| [r, g, b]).collect()
    }
}

/// Writes float32 columns as Parquet.
pub fn write(path: &str, columns: &[(&str, Vec<f32>)]) {
    write_with(path, columns, None);
}

/// The same with the names of each row's light.
pub fn write_lit(path: &str, columns: &[(&str, Vec<f32>)], lights: &[&str]) {
    write_with(path, columns, Some(lights));
}

fn write_with(path: &str, columns: &[(&str, Vec<f32>)], lights: Option<&[&str]>) {
    let field = |(name, _): &(&str, Vec<f32>)| Field::new(*name, DataType::Float32, false);
    let mut fields: Vec<Field> = columns.iter().map(field).collect();
    let number = |(_, values): &(&str, Vec<f32>)| -> ArrayRef {
        Arc::new(Float32Array::from(values.clone()))
    };
    let mut arrays: Vec<ArrayRef> = columns.iter().map(number).collect();
    if let Some(lights) = lights {
        fields.push(Field::new("light", DataType::Utf8, false));
        arrays.push(Arc::new(StringArray::from(lights.to_vec())));
    }
    let schema = Arc::new(Schema::new(fields));
    let batch = RecordBatch::try_new(schema.clone(), arrays).expect("equal lengths");
    let file = File::create(path).expect("a temporary file");
    let mut writer = ArrowWriter::try_new(file, schema, None).expect("a writer");
    writer.write(&batch).expect("a written table");
    writer.close().expect("a closed table");
}
