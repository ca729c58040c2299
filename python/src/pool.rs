//! Thread pools of native work: the one of the process, or one of the calling thread's own.

use std::cell::RefCell;
use std::sync::Arc;

use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use trundle_sim::{SimError, thread_pool};

use crate::error::refused;

thread_local! {
    static OWN: RefCell<Option<Arc<ThreadPool>>> = const { RefCell::new(None) };
}

/// Stack size of the thread of an own pool, bytes; as in the pool of the process.
const STACK_BYTES: usize = 8 << 20;

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(_work_in_own_pool, module)?)?;
    module.add_function(wrap_pyfunction!(_pool_threads, module)?)
}

/// Pool for the work that the calling thread starts.
///
/// # Errors
/// If the system cannot create the threads.
pub(crate) fn pool() -> Result<Arc<ThreadPool>, SimError> {
    match OWN.with_borrow(Clone::clone) {
        Some(own) => Ok(own),
        None => thread_pool(),
    }
}

/// From now on, run native work of the calling Python thread in a pool of one thread of its own. Long work in the pool of
/// the process would delay the work of all other threads.
#[pyfunction]
fn _work_in_own_pool() -> PyResult<()> {
    let builder = ThreadPoolBuilder::new().num_threads(1).stack_size(STACK_BYTES);
    let own = builder.thread_name(|_| "trundle-background".to_owned()).build().map_err(refused)?;
    OWN.set(Some(Arc::new(own)));
    Ok(())
}

/// Number of threads that native work of the calling Python thread uses.
#[pyfunction]
fn _pool_threads() -> PyResult<usize> {
    Ok(pool().map_err(refused)?.current_num_threads())
}
