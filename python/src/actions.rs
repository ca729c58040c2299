//! Actions from Python: numbers in [-1, 1], as many as the action mode needs.

use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use trundle_sim::task::constants::MAX_ACTION_WIDTH;

use crate::error::refused;

/// An action: the given number of entries, in [-1, 1] unless they are clipped later. Unused entries are 0.
pub(crate) fn numbers(
    action: &Bound<'_, PyAny>,
    width: usize,
    clips: bool,
) -> PyResult<[f64; MAX_ACTION_WIDTH]> {
    let read = if let Ok(array) = action.extract::<PyReadonlyArray1<'_, f32>>() {
        padded(width, array.as_array().iter().map(|v| f64::from(*v)))
    } else if let Ok(array) = action.extract::<PyReadonlyArray1<'_, f64>>() {
        padded(width, array.as_array().iter().copied())
    } else {
        padded(width, float64(action)?.as_array().iter().copied())
    };
    let Some(numbers) = read else {
        let shape = action.py().import("numpy")?.getattr("shape")?.call1((action,))?;
        return Err(refused(format!("an action has shape ({width},), not {shape}: numbers in [-1, 1]")));
    };
    check(numbers.get(..width).unwrap_or(&numbers), clips)?;
    Ok(numbers)
}

fn padded(width: usize, mut entries: impl ExactSizeIterator<Item = f64>) -> Option<[f64; MAX_ACTION_WIDTH]> {
    (entries.len() == width).then(|| [(); MAX_ACTION_WIDTH].map(|()| entries.next().unwrap_or(0.0)))
}

fn float64<'py>(action: &Bound<'py, PyAny>) -> PyResult<PyReadonlyArray1<'py, f64>> {
    let py = action.py();
    let array = py.import("numpy")?.getattr("asarray")?.call1((action, "float64"));
    let array = array.map_err(|e| refused(format!("an action is numbers in [-1, 1]: {e}")))?;
    // Another number of dimensions gives a row that is too short, which the caller rejects.
    Ok(array.extract().unwrap_or_else(|_| PyArray1::zeros(py, 0, false).readonly()))
}

pub(crate) fn many_numbers(
    actions: &Bound<'_, PyAny>,
    count: usize,
    width: usize,
    clips: bool,
) -> PyResult<Vec<f64>> {
    let py = actions.py();
    let array = py.import("numpy")?.getattr("ascontiguousarray")?.call1((actions, "float64"));
    let array = array.map_err(|e| refused(format!("actions are numbers in [-1, 1]: {e}")))?;
    let rows = array.extract::<PyReadonlyArray2<'_, f64>>().ok();
    let Some(rows) = rows.filter(|rows| rows.as_array().dim() == (count, width)) else {
        let shape = array.getattr("shape")?;
        return Err(refused(format!("actions have shape ({count}, {width}), not {shape}")));
    };
    let numbers = rows.as_slice().map_err(refused)?.to_vec();
    for (index, row) in numbers.chunks(width).enumerate() {
        check(row, clips).map_err(|error| refused(format!("environment {index}: {}", error.value(py))))?;
    }
    Ok(numbers)
}

fn check(numbers: &[f64], clips: bool) -> PyResult<()> {
    if numbers.iter().all(|v| v.abs() <= 1.0 || (clips && v.is_finite())) {
        return Ok(());
    }
    if !numbers.iter().all(|v| v.is_finite()) {
        return Err(refused(format!("action {numbers:?}: each entry must be a finite number in [-1, 1]")));
    }
    Err(refused(format!(
        "action {numbers:?}: each entry must lie in [-1, 1]; gymnasium.wrappers.ClipAction cuts it"
    )))
}
