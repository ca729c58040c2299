//! Serialised results as plain Python objects, and back.

use pyo3::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::error::refused;

/// The value as dicts, lists, floats and strings, in the order of its fields.
///
/// Python's `json` module creates the objects, which is as fast as creating them here.
pub(crate) fn plain<'py>(py: Python<'py>, value: &impl Serialize) -> PyResult<Bound<'py, PyAny>> {
    let text = serde_json::to_string(value).map_err(refused)?;
    py.import("json")?.call_method1("loads", (text,))
}

/// The value that `plain` converted to a Python object.
pub(crate) fn parsed<T: DeserializeOwned>(value: &Bound<'_, PyAny>) -> PyResult<T> {
    let text: String = value.py().import("json")?.call_method1("dumps", (value,))?.extract()?;
    serde_json::from_str(&text).map_err(refused)
}
