//! Scenarios in Python.

use std::path::PathBuf;

use pyo3::prelude::*;
use trundle_sim::Scenario;

use crate::error::run;
use crate::record::PyRecording;

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(simulate, module)?)
}

/// Simulate a scenario and record it.
///
/// Parameters
/// ----------
/// scenario : str or os.PathLike
///     A scenario file, as those in ``configs/experiments``.
/// seed : int
///     Seed of everything random.
///
/// Returns
/// -------
/// Recording
///     The same for the same scenario and seed.
///
/// Raises
/// ------
/// TrundleError
///     If the scenario is not sound; the message names file, key, value and remedy.
#[pyfunction]
#[pyo3(signature = (scenario, seed = 0))]
fn simulate(py: Python<'_>, scenario: PathBuf, seed: u64) -> PyResult<PyRecording> {
    run(py, || {
        let (scenario, model) = Scenario::read(&scenario)?;
        trundle_sim::simulate(&scenario, &model, seed)
    })
    .map(PyRecording::wrap)
}
