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
///     A scenario file, such as those in ``configs/experiments``.
/// seed : int
///     Seed of all random numbers.
///
/// Returns
/// -------
/// Recording
///     The recording. The same scenario and seed give the same recording.
///
/// Raises
/// ------
/// TrundleError
///     If the scenario is invalid. The message names file, key, value and remedy.
///
/// Examples
/// --------
/// >>> recording = trundle.simulate("scenario.toml", seed=1)
/// >>> len(recording)
/// 3
#[pyfunction]
#[pyo3(signature = (scenario, seed = 0))]
fn simulate(py: Python<'_>, scenario: PathBuf, seed: u64) -> PyResult<PyRecording> {
    run(py, || {
        let (scenario, model) = Scenario::read(&scenario)?;
        trundle_sim::simulate(&scenario, &model, seed)
    })
    .map(PyRecording::wrap)
}
