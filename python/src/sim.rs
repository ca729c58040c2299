//! Scenarios in Python.

use std::path::PathBuf;

use pyo3::prelude::*;
use trundle_sim::Scenario;

use crate::error::run;
use crate::record::PyRecording;

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(simulate, module)?)?;
    module.add_function(wrap_pyfunction!(demo, module)?)
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

/// Simulate the demo: pushes of an office table with a locked wheel and dry friction at one foot.
///
/// Parameters
/// ----------
/// seed : int
///     Seed of all random numbers.
///
/// Returns
/// -------
/// Recording
///     Eight episodes of 6 s, the last two held out. The recording does not contain the hidden effects.
///
/// Examples
/// --------
/// >>> import trundle
/// >>> list(trundle.demo().episodes)[:2]
/// ['episode_00', 'episode_01']
#[pyfunction]
#[pyo3(signature = (seed = 0))]
fn demo(py: Python<'_>, seed: u64) -> PyResult<PyRecording> {
    run(py, || {
        let (scenario, model) = Scenario::demo()?;
        trundle_sim::simulate(&scenario, &model, seed)
    })
    .map(PyRecording::wrap)
}
