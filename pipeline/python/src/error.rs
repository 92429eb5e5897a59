//! Failures as exceptions, in the commands' own words.

use pyo3::create_exception;
use pyo3::exceptions::PyException;
use pyo3::prelude::*;
use rrf_cli::embedded::CommandError;

create_exception!(
    rrf,
    RrfError,
    PyException,
    "A command failed; it could succeed if tried again."
);
create_exception!(
    rrf,
    BadInput,
    RrfError,
    "The input or an option is not what a command takes."
);

/// The exception for a failure.
pub fn raised(error: CommandError) -> PyErr {
    match error.exit_code {
        2 => BadInput::new_err(error.message),
        _ => RrfError::new_err(error.message),
    }
}
