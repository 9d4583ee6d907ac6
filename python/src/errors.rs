//! Errors of the library as Python's `willis.WillisError`.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use willis::Error;
use willis::cli::words::arguments_in;
use willis::error::Place;
use willis::internals::support::printable::printable;

/// The exception for an error.
pub fn raised(py: Python<'_>, error: &Error) -> PyErr {
    made(py, error).unwrap_or_else(|failed| failed)
}

fn made(py: Python<'_>, error: &Error) -> PyResult<PyErr> {
    let fields = PyDict::new(py);
    match error {
        Error::Input { path, place, found, accepted } => {
            fields.set_item("file", Some(path).filter(|path| !path.as_os_str().is_empty()))?;
            match place {
                Place::File => {}
                Place::Line(line) => fields.set_item("line", line)?,
                Place::Item(item) => fields.set_item("item", item)?,
            }
            fields.set_item("value", found)?;
            fields.set_item("expected", arguments_in(accepted))?;
        }
        Error::Parameter { name, value, accepted } => {
            fields.set_item("item", name)?;
            fields.set_item("value", value)?;
            fields.set_item("expected", arguments_in(accepted))?;
        }
        Error::Read { path, .. } | Error::Write { path, .. } | Error::Exists { path } => fields.set_item("file", path)?,
        _ => {}
    }
    let class = py.import("willis._errors")?.getattr("WillisError")?;
    // Functions call the place where they write folder, path or output.
    let text = arguments_in(&error.to_string()).replace("another `output`", "another place");
    Ok(PyErr::from_value(class.call((printable(&text),), Some(&fields))?))
}
