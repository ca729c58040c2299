//! Python exceptions, and execution of work on the thread pool.

use std::fmt::Display;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use pyo3::create_exception;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use trundle_model::ModelError;
use trundle_sim::SimError;

use crate::pool::pool;

create_exception!(
    trundle,
    TrundleError,
    PyValueError,
    "An invalid recording, model or argument. The message contains the place, the reason and the remedy."
);

create_exception!(
    trundle,
    NotFiniteError,
    TrundleError,
    "A motion that is not finite. The message names the likely cause."
);

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("NotFiniteError", module.py().get_type::<NotFiniteError>())?;
    module.add("TrundleError", module.py().get_type::<TrundleError>())
}

/// A typed Rust error as `trundle.TrundleError`.
pub(crate) fn refused(error: impl Display) -> PyErr {
    TrundleError::new_err(error.to_string())
}

/// Like [`refused`]; a motion that is not finite becomes `NotFiniteError`.
pub(crate) fn simulated(error: SimError) -> PyErr {
    match &error {
        SimError::Model(ModelError::NotFinite(_)) => NotFiniteError::new_err(error.to_string()),
        _ => refused(error),
    }
}

/// Runs `work` on the thread pool of the calling thread with the interpreter released. An error becomes `TrundleError`; a
/// panic, which is a bug in trundle, becomes `RuntimeError`.
///
/// All work that may use threads runs here. A forked child has no threads of rayon's global pool and would wait for
/// them forever.
pub(crate) fn run<T: Send, E: Display + Send>(
    py: Python<'_>,
    work: impl FnOnce() -> Result<T, E> + Send,
) -> PyResult<T> {
    let pool = pool().map_err(refused)?;
    run_here(py, move || pool.install(work))
}

/// Like [`run`], on the calling thread, for short work that uses only threads of `pool`.
pub(crate) fn run_here<T: Send, E: Display + Send>(
    py: Python<'_>,
    work: impl FnOnce() -> Result<T, E> + Send,
) -> PyResult<T> {
    match py.detach(|| catch_unwind(AssertUnwindSafe(work))) {
        Ok(result) => result.map_err(refused),
        Err(_) => Err(PyRuntimeError::new_err("internal error in trundle; please report it with the input")),
    }
}

/// An error of the file at `path`.
pub(crate) fn in_file(path: &Path, error: impl Display) -> PyErr {
    refused(format!("{}: {error}", path.display()))
}
