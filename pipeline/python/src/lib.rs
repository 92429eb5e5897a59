//! The Python module `rrf._native`: the commands of `rrf` with tables and frames in memory.
//!
//! `python/rrf/__init__.py` is what people call; it turns keyword arguments into words of the command line.

mod bake;
mod error;
mod run;
mod stream;

use pyo3::prelude::*;
use std::ffi::OsString;

/// Runs a whole command line, the program's name first; its exit code.
#[pyfunction]
fn command(py: Python<'_>, words: Vec<OsString>) -> u8 {
    py.detach(|| rrf_cli::embedded::run_command(words))
}

#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("RrfError", module.py().get_type::<error::RrfError>())?;
    module.add("BadInput", module.py().get_type::<error::BadInput>())?;
    module.add_class::<run::Run>()?;
    module.add_class::<stream::Table>()?;
    module.add_function(wrap_pyfunction!(command, module)?)?;
    module.add_function(wrap_pyfunction!(stream::read_table, module)?)?;
    module.add_function(wrap_pyfunction!(bake::bake, module)?)?;
    Ok(())
}
