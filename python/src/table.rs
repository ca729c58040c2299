//! Tables of named columns, written as Parquet files.

use std::path::PathBuf;

use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use trundle_record::{Column, write_parquet};

use crate::error::run;

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(_write_table, module)?)
}

/// A column with its own values.
enum Owned {
    Numbers(Vec<f64>),
    Texts(Vec<String>),
    Flags(Vec<bool>),
}

impl Owned {
    fn borrowed(&self) -> Column<'_> {
        match self {
            Self::Numbers(values) => Column::Numbers(values),
            Self::Texts(values) => Column::Texts(values),
            Self::Flags(values) => Column::Flags(values),
        }
    }
}

/// Write columns, lists of str, and arrays of bool and of float64 with NaN for no value, as a Parquet file.
#[pyfunction]
fn _write_table(py: Python<'_>, path: PathBuf, columns: Vec<(String, Bound<'_, PyAny>)>) -> PyResult<()> {
    let mut owned = Vec::with_capacity(columns.len());
    for (name, values) in &columns {
        let column = if let Ok(flags) = values.extract::<PyReadonlyArray1<'_, bool>>() {
            Owned::Flags(flags.as_array().to_vec())
        } else if let Ok(numbers) = values.extract::<PyReadonlyArray1<'_, f64>>() {
            Owned::Numbers(numbers.as_array().to_vec())
        } else {
            Owned::Texts(values.extract()?)
        };
        owned.push((name, column));
    }
    let borrowed: Vec<(&str, Column<'_>)> =
        owned.iter().map(|(name, values)| (name.as_str(), values.borrowed())).collect();
    run(py, || write_parquet(&path, &borrowed))
}
