//! Episode tables as dictionaries of NumPy arrays and back.

use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};
use trundle_record::Episode;

use crate::error::refused;

/// Every column by name, `t` first: read-only float64 arrays, and lists of strings for notes.
pub(crate) fn to_dict<'py>(py: Python<'py>, episode: &Episode) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("t", array(py, &episode.t)?)?;
    for name in episode.header() {
        match episode.notes.get(name) {
            Some(texts) => dict.set_item(name, texts)?,
            None => dict.set_item(name, array(py, &episode.columns[name])?)?,
        }
    }
    Ok(dict)
}

/// A read-only array, because all callers share it.
fn array<'py>(py: Python<'py>, cells: &[f64]) -> PyResult<Bound<'py, PyAny>> {
    let array = PyArray1::from_slice(py, cells).into_any();
    array.call_method("setflags", (), Some(&[("write", false)].into_py_dict(py)?))?;
    Ok(array)
}

/// A mapping (or data frame) from column names to sequences as an episode.
///
/// # Errors
/// `TrundleError`, naming episode and column, for cells that are not numbers.
pub(crate) fn from_mapping(name: &str, columns: &Bound<'_, PyAny>) -> PyResult<Episode> {
    let mut episode = Episode { name: name.to_owned(), ..Episode::default() };
    for item in columns.call_method0("items")?.try_iter()? {
        let (title, cells): (String, Bound<'_, PyAny>) = item?.extract()?;
        if title.starts_with("note_") {
            episode.notes.insert(title, texts(&cells)?);
        } else {
            let cells = numbers(&cells).map_err(|reason| {
                refused(format!("episode {name}, column {title}: not a sequence of numbers ({reason}); give float64, NaN where a cell is empty"))
            })?;
            episode.insert(title, cells);
        }
    }
    Ok(episode)
}

fn numbers(cells: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let py = cells.py();
    let asarray = py.import("numpy")?.getattr("asarray")?;
    let array: PyReadonlyArray1<'_, f64> = asarray.call1((cells, "float64"))?.extract()?;
    Ok(array.as_array().to_vec())
}

/// Cells as text; empty for `None` and NaN.
fn texts(cells: &Bound<'_, PyAny>) -> PyResult<Vec<String>> {
    let text = |cell: PyResult<Bound<'_, PyAny>>| {
        let cell = cell?;
        // Only NaN differs from itself.
        Ok(if cell.is_none() || cell.ne(&cell)? { String::new() } else { cell.str()?.extract()? })
    };
    cells.try_iter()?.map(text).collect()
}
