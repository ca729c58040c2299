//! The inner loops of `trundle.experiments.paper`: learning curves of transitions, and pushes planned once and carried out blind.

mod course;
mod curves;
mod learners;

use pyo3::prelude::*;

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    curves::register(module)?;
    course::register(module)
}
