//! TOML tables as Python dictionaries and back.

use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString, PyTuple};
use toml::value::{Datetime, Offset};
use toml::{Table, Value};

use crate::error::refused;

/// A table as a new `dict`. Dates and times become objects of `datetime`, truncated to microseconds.
pub(crate) fn to_dict<'py>(py: Python<'py>, table: &Table) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for (key, value) in table {
        dict.set_item(key, to_python(py, value)?)?;
    }
    Ok(dict)
}

fn to_python<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    Ok(match value {
        Value::String(text) => PyString::new(py, text).into_any(),
        Value::Integer(number) => number.into_pyobject(py)?.into_any(),
        Value::Float(number) => PyFloat::new(py, *number).into_any(),
        Value::Boolean(truth) => PyBool::new(py, *truth).to_owned().into_any(),
        Value::Datetime(moment) => moment_to_python(py, moment)?,
        Value::Table(table) => to_dict(py, table)?.into_any(),
        Value::Array(values) => {
            let list = PyList::empty(py);
            for value in values {
                list.append(to_python(py, value)?)?;
            }
            list.into_any()
        }
    })
}

/// A date or time in the only format that `fromisoformat` of Python 3.10 accepts.
fn moment_to_python<'py>(py: Python<'py>, moment: &Datetime) -> PyResult<Bound<'py, PyAny>> {
    let class = match (&moment.date, &moment.time) {
        (Some(_), Some(_)) => "datetime",
        (Some(_), None) => "date",
        _ => "time",
    };
    let mut text = moment.date.map_or(String::new(), |date| date.to_string());
    if let Some(time) = moment.time {
        let separator = if text.is_empty() { "" } else { "T" };
        let (second, micros) = (time.second.unwrap_or(0), time.nanosecond.unwrap_or(0) / 1000);
        text += &format!("{separator}{:02}:{:02}:{second:02}.{micros:06}", time.hour, time.minute);
    }
    if let Some(offset) = moment.offset {
        let minutes = match offset {
            Offset::Z => 0,
            Offset::Custom { minutes } => minutes,
        };
        let sign = if minutes < 0 { '-' } else { '+' };
        text += &format!("{sign}{:02}:{:02}", minutes.abs() / 60, minutes.abs() % 60);
    }
    py.import("datetime")?.getattr(class)?.call_method1("fromisoformat", (text,))
}

/// A mapping as a table.
///
/// # Errors
/// `TrundleError`, naming the key, for a value that TOML cannot hold.
pub(crate) fn from_dict(mapping: &Bound<'_, PyAny>, what: &str) -> PyResult<Table> {
    table(mapping, what)
}

fn table(mapping: &Bound<'_, PyAny>, path: &str) -> PyResult<Table> {
    let mut table = Table::new();
    for item in mapping.call_method0("items")?.try_iter()? {
        let (key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>) = item?.extract()?;
        let key: String =
            key.extract().map_err(|_| refused(format!("{path}: the key {key} is not a string")))?;
        let value = from_python(&value, &format!("{path}.{key}"))?;
        table.insert(key, value);
    }
    Ok(table)
}

fn from_python(value: &Bound<'_, PyAny>, path: &str) -> PyResult<Value> {
    if let Ok(truth) = value.cast::<PyBool>() {
        return Ok(Value::Boolean(truth.is_true()));
    }
    if value.is_instance_of::<PyInt>() {
        let number = value.extract().map_err(|_| refused(format!("{path}: {value} does not fit 64 bits")))?;
        return Ok(Value::Integer(number));
    }
    if value.is_instance_of::<PyFloat>() {
        return Ok(Value::Float(value.extract()?));
    }
    if value.is_instance_of::<PyString>() {
        return Ok(Value::String(value.extract()?));
    }
    if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        let values = value.try_iter()?.enumerate();
        let values = values.map(|(i, value)| from_python(&value?, &format!("{path}[{i}]")));
        return Ok(Value::Array(values.collect::<PyResult<_>>()?));
    }
    if value.hasattr("items")? {
        return Ok(Value::Table(table(value, path)?));
    }
    if value.hasattr("tolist")? {
        return from_python(&value.call_method0("tolist")?, path);
    }
    if value.hasattr("isoformat")? {
        return moment_from_python(value, path);
    }
    let kind = value.get_type().name()?;
    Err(refused(format!(
        "{path}: a value of type {kind} cannot be written as TOML; remove the key, or write it as text"
    )))
}

fn moment_from_python(value: &Bound<'_, PyAny>, path: &str) -> PyResult<Value> {
    let text: String = value.call_method0("isoformat")?.extract()?;
    let text = text.strip_suffix("+00:00").map_or(text.clone(), |local| format!("{local}Z"));
    let moment = text.parse().map_err(|_| refused(format!("{path}: {text} is not a TOML date or time")))?;
    Ok(Value::Datetime(moment))
}
