//! Tables in and out by the Arrow C stream interface, without copies.

use crate::error::RrfError;
use arrow::array::{RecordBatch, RecordBatchIterator, RecordBatchReader};
use arrow::compute::concat_batches;
use arrow::ffi_stream::{FFI_ArrowArrayStream, RecordBatchStreamReader};
use arrow::ipc::reader::FileReader;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyCapsule;
use std::ffi::CStr;
use std::fs::File;
use std::path::PathBuf;

const NAME: &CStr = c"arrow_array_stream";

/// The rows of anything that has `__arrow_c_stream__`. A table of one batch stays where it is; several
/// are joined.
pub fn rows_of(table: &Bound<'_, PyAny>) -> PyResult<RecordBatch> {
    if !table.hasattr("__arrow_c_stream__")? {
        let kind = table.get_type().name()?;
        return Err(PyTypeError::new_err(format!(
            "{kind} has no __arrow_c_stream__; pyarrow, polars and DuckDB tables have"
        )));
    }
    let capsule = table.call_method0("__arrow_c_stream__")?;
    let capsule = capsule.cast::<PyCapsule>()?;
    let stream = capsule.pointer_checked(Some(NAME))?.as_ptr();
    // SAFETY: a capsule of this name holds a stream (checked above), which is moved out of it here and
    // marked as released, as the interface says.
    let reader = unsafe { RecordBatchStreamReader::from_raw(stream.cast()) };
    let wrong = |error: arrow::error::ArrowError| PyValueError::new_err(error.to_string());
    let reader = reader.map_err(wrong)?;
    let schema = reader.schema();
    let batches = reader
        .collect::<Result<Vec<RecordBatch>, _>>()
        .map_err(wrong)?;
    match <[RecordBatch; 1]>::try_from(batches) {
        Ok([one]) => Ok(one),
        Err(batches) => concat_batches(&schema, &batches).map_err(wrong),
    }
}

/// A table of Rust's that Python programs take by its `__arrow_c_stream__`.
#[pyclass(frozen)]
pub struct Table(pub RecordBatch);

#[pymethods]
impl Table {
    /// The rows as a stream, for pyarrow, polars, DuckDB and others.
    #[pyo3(signature = (requested_schema=None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        // the interface lets a producer give what it has
        let _ = requested_schema;
        let rows = RecordBatchIterator::new([Ok(self.0.clone())], self.0.schema());
        let stream = FFI_ArrowArrayStream::new(Box::new(rows));
        PyCapsule::new_with_value(py, stream, NAME)
    }

    fn __len__(&self) -> usize {
        self.0.num_rows()
    }

    fn __repr__(&self) -> String {
        let schema = self.0.schema();
        let names: Vec<&str> = schema.fields().iter().map(|f| f.name().as_str()).collect();
        format!(
            "<rrf.Table: {} rows of {}>",
            self.0.num_rows(),
            names.join(", ")
        )
    }
}

/// One of a run's Arrow tables.
#[pyfunction]
pub fn read_table(path: PathBuf) -> PyResult<Table> {
    let wrong = |reason: String| RrfError::new_err(format!("{}: {reason}", path.display()));
    let file = File::open(&path).map_err(|error| wrong(error.to_string()))?;
    let reader = FileReader::try_new(file, None).map_err(|error| wrong(error.to_string()))?;
    let schema = reader.schema();
    let batches = reader.collect::<Result<Vec<RecordBatch>, _>>();
    let batches = batches.map_err(|error| wrong(error.to_string()))?;
    let table = concat_batches(&schema, &batches).map_err(|error| wrong(error.to_string()))?;
    Ok(Table(table))
}
