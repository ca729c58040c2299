//! Native work of Python threads that must not delay other threads.

use pyo3::prelude::*;

use crate::error::refused;
use crate::pool::{pool, use_own_pool};

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(_work_in_own_pool, module)?)?;
    module.add_function(wrap_pyfunction!(_pool_threads, module)?)
}

/// From now on, run native work of the calling Python thread in a pool of one thread of its own. Long work in the pool of
/// the process would delay the work of all other threads.
#[pyfunction]
fn _work_in_own_pool() -> PyResult<()> {
    use_own_pool().map_err(refused)
}

/// Number of threads that native work of the calling Python thread uses.
#[pyfunction]
fn _pool_threads() -> PyResult<usize> {
    Ok(pool().map_err(refused)?.current_num_threads())
}
