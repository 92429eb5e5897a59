//! A baked run, held open.

use crate::error::raised;
use crate::stream::{Table, rows_of};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use rrf_cli::embedded::OpenRun;
use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// A baked run, held open.
#[pyclass(frozen)]
pub struct Run {
    run: Mutex<OpenRun>,
}

impl Run {
    fn open_run(&self) -> MutexGuard<'_, OpenRun> {
        self.run.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[pymethods]
impl Run {
    #[new]
    fn new(py: Python<'_>, run: PathBuf, trust_error: f32) -> PyResult<Run> {
        let opened = py.detach(|| OpenRun::open(&run, trust_error));
        Ok(Run {
            run: Mutex::new(opened.map_err(raised)?),
        })
    }

    fn query(&self, py: Python<'_>, table: &Bound<'_, PyAny>, blend: bool) -> PyResult<Table> {
        let rows = rows_of(table)?;
        let answered = py.detach(|| self.open_run().query(rows, blend));
        Ok(Table(answered.map_err(raised)?))
    }

    fn trace(
        &self,
        py: Python<'_>,
        table: &Bound<'_, PyAny>,
        words: Vec<OsString>,
    ) -> PyResult<Table> {
        let rows = rows_of(table)?;
        let traced = py.detach(|| self.open_run().trace(rows, &words));
        Ok(Table(traced.map_err(raised)?))
    }

    /// Height, width, and the linear picture as float32, row by row, red, green and blue.
    fn render<'py>(
        &self,
        py: Python<'py>,
        words: Vec<OsString>,
    ) -> PyResult<(u32, u32, Bound<'py, PyBytes>)> {
        let frame = py
            .detach(|| self.open_run().render(&words))
            .map_err(raised)?;
        let length = frame.full.len() * 12;
        let bytes = PyBytes::new_with(py, length, |bytes| {
            let channels = frame.full.iter().flat_map(|pixel| pixel.to_array());
            for (place, value) in bytes.chunks_exact_mut(4).zip(channels) {
                place.copy_from_slice(&value.to_le_bytes());
            }
            Ok(())
        })?;
        Ok((frame.height, frame.width, bytes))
    }

    fn manifest(&self) -> PyResult<String> {
        self.open_run().manifest().map_err(raised)
    }
}
