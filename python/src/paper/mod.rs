//! Inner loops of `trundle.experiments.paper`: learning curves, and open-loop pushes.

mod course;
mod curves;
mod learners;

use pyo3::prelude::*;

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    curves::register(module)?;
    course::register(module)
}
