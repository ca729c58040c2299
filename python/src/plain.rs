//! Serialised results as plain Python objects, and back.

use pyo3::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::error::refused;

/// The value as dicts, lists, floats and strings, in the order of its fields.
///
/// Python's own `json` module builds the objects, which is as fast as building them here and shorter.
pub(crate) fn plain<'py>(py: Python<'py>, value: &impl Serialize) -> PyResult<Bound<'py, PyAny>> {
    let text = serde_json::to_string(value).map_err(refused)?;
    py.import("json")?.call_method1("loads", (text,))
}

/// The value that `plain` made a Python object of.
pub(crate) fn parsed<T: DeserializeOwned>(value: &Bound<'_, PyAny>) -> PyResult<T> {
    let text: String = value.py().import("json")?.call_method1("dumps", (value,))?.extract()?;
    serde_json::from_str(&text).map_err(refused)
}
