//! The Python exception for unusable input, and the gate through which all work runs.

use std::fmt::Display;
use std::panic::{AssertUnwindSafe, catch_unwind};

use pyo3::create_exception;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use trundle_model::ModelError;
use trundle_sim::{SimError, thread_pool};

create_exception!(
    trundle,
    TrundleError,
    PyValueError,
    "A recording, model or argument that cannot be used; the message says where, why, and what to do."
);

create_exception!(
    trundle,
    NotFiniteError,
    TrundleError,
    "A motion that leaves the range of numbers; the message names the parameter to look at first."
);

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("NotFiniteError", module.py().get_type::<NotFiniteError>())?;
    module.add("TrundleError", module.py().get_type::<TrundleError>())
}

/// A typed Rust error as `trundle.TrundleError`.
pub(crate) fn refused(error: impl Display) -> PyErr {
    TrundleError::new_err(error.to_string())
}

/// The same; a motion that is not finite becomes `NotFiniteError`.
pub(crate) fn simulated(error: SimError) -> PyErr {
    match &error {
        SimError::Model(ModelError::NotFinite(_)) => NotFiniteError::new_err(error.to_string()),
        _ => refused(error),
    }
}

/// Runs `work` on the thread pool of this process with the interpreter released. Its error becomes `TrundleError`; a
/// panic, which would be a fault of ours, becomes `RuntimeError`.
///
/// Everything that may use threads passes through here: a forked child has none of the threads of rayon's global
/// pool, and would wait for them for ever.
pub(crate) fn run<T: Send, E: Display + Send>(
    py: Python<'_>,
    work: impl FnOnce() -> Result<T, E> + Send,
) -> PyResult<T> {
    let pool = thread_pool().map_err(refused)?;
    run_here(py, move || pool.install(work))
}

/// The same on the calling thread, for work of microseconds that uses no threads but those of `thread_pool`.
pub(crate) fn run_here<T: Send, E: Display + Send>(
    py: Python<'_>,
    work: impl FnOnce() -> Result<T, E> + Send,
) -> PyResult<T> {
    match py.detach(|| catch_unwind(AssertUnwindSafe(work))) {
        Ok(result) => result.map_err(refused),
        Err(_) => Err(PyRuntimeError::new_err("internal error in trundle; please report it with the input")),
    }
}
