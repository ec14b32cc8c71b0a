//! Failures as exceptions of Python: file, line, key and hint come along, and no panic crosses the border.

use std::panic::{AssertUnwindSafe, catch_unwind};

use palpate_files::FileError;
use palpate_run::Failure;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// An exception of `palpate` by its class's name.
pub fn raise(class: &str, message: &str) -> PyErr {
    Python::attach(|py| made(py, class, message, None).unwrap_or_else(|error| error))
}

fn made(
    py: Python<'_>,
    class: &str,
    message: &str,
    parts: Option<&Bound<'_, PyDict>>,
) -> PyResult<PyErr> {
    let class = py.import("palpate._errors")?.getattr(class)?;
    Ok(PyErr::from_value(class.call((message,), parts)?))
}

/// A failure as an exception.
pub fn exception(failure: &Failure) -> PyErr {
    let class = match failure {
        Failure::Check(_) => "CheckError",
        Failure::Input(_) | Failure::File(_) => "InputError",
        Failure::Device(_) | Failure::Write { .. } => "DeviceError",
        Failure::Guard(_) => "GuardError",
        Failure::Stopped(_) => return pyo3::exceptions::PyKeyboardInterrupt::new_err(()),
    };
    Python::attach(|py| {
        let parts = PyDict::new(py);
        parts.set_item("file", failure.file())?;
        parts.set_item("line", failure.line())?;
        parts.set_item("key", failure.key())?;
        if let Failure::File(error) = failure {
            parts.set_item("expected", &error.expected)?;
            parts.set_item("found", &error.found)?;
            parts.set_item("hint", hint(error))?;
        }
        made(py, class, &failure.to_string(), Some(&parts))
    })
    .unwrap_or_else(|error| error)
}

/// Hint on a file: take the name that was meant, or write what was expected.
fn hint(error: &FileError) -> String {
    match error.found.split_once("did you mean ") {
        Some((_, meant)) => format!("use {}", meant.trim_end_matches('?')),
        None => format!("write {}", error.expected),
    }
}

/// Does a piece of work without the interpreter's lock, so that other threads of Python go on.
///
/// # Errors
/// Its failure as an exception; a panic as `BugError`.
pub fn free<T: Send>(
    py: Python<'_>,
    work: impl FnOnce() -> Result<T, Failure> + Send,
) -> PyResult<T> {
    // Objects that a panic came through refuse later calls: their state is not used again.
    match py.detach(|| catch_unwind(AssertUnwindSafe(work))) {
        Ok(Ok(value)) => Ok(value),
        Ok(Err(failure)) => Err(exception(&failure)),
        Err(panic) => {
            let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
            let text = text.or_else(|| panic.downcast_ref::<String>().cloned());
            let text = text.unwrap_or_else(|| "a panic without words".into());
            Err(raise("BugError", &format!("a fault of palpate: {text}")))
        }
    }
}
