//! Thread pools of native work: the one of the process, or one of the calling thread's own.

use std::cell::RefCell;
use std::sync::Arc;

use rayon::{ThreadPool, ThreadPoolBuilder};
use trundle_sim::{SimError, thread_pool};

thread_local! {
    static OWN: RefCell<Option<Arc<ThreadPool>>> = const { RefCell::new(None) };
}

/// Stack size of the thread of an own pool, bytes; as in the pool of the process.
const STACK_BYTES: usize = 8 << 20;

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

/// From now on, [`pool`] returns a pool of one thread that belongs to the calling thread.
///
/// # Errors
/// If the system cannot create the thread.
pub(crate) fn use_own_pool() -> Result<(), SimError> {
    let builder = ThreadPoolBuilder::new().num_threads(1).stack_size(STACK_BYTES);
    let own = builder.thread_name(|_| "trundle-background".to_owned()).build();
    OWN.set(Some(Arc::new(own.map_err(|error| SimError::Threads(error.to_string()))?)));
    Ok(())
}
