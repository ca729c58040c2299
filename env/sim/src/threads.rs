//! The thread pool of this process.

use std::sync::{Arc, Mutex, TryLockError};
use std::time::{Duration, Instant};

use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::SimError;

/// Stack of each thread, bytes: that of a main thread on Linux, so that work may move between them.
const STACK: usize = 8 << 20;

/// How long to wait for the lock. It is held for less than a microsecond, unless the thread that held it was lost in
/// a fork.
const MAX_LOCK_WAIT: Duration = Duration::from_millis(100);

/// A pool, and the process whose threads it has.
type Kept = Option<(u32, Arc<ThreadPool>)>;

static POOL: Mutex<Kept> = Mutex::new(None);

/// Returns the thread pool of this process.
///
/// A forked child has none of its parent's threads, so work given to the parent's pool would wait for ever. The pool
/// is therefore kept with the process id, and built again where that has changed. Rayon's global pool cannot be
/// built again: everything that uses threads must run in this one.
///
/// # Errors
/// When the system gives no threads.
pub fn thread_pool() -> Result<Arc<ThreadPool>, SimError> {
    let own = std::process::id();
    let known =
        with_pool(|kept| kept.as_ref().filter(|(process, _)| *process == own).map(|(_, p)| p.clone()));
    if let Some(pool) = known.flatten() {
        return Ok(pool);
    }
    let builder = ThreadPoolBuilder::new().stack_size(STACK).thread_name(|k| format!("trundle-{k}"));
    let pool = Arc::new(builder.build().map_err(|e| SimError::Threads(e.to_string()))?);
    let current = with_pool(|kept| match kept {
        // Another thread was faster.
        Some((process, first)) if *process == own => first.clone(),
        _ => {
            // To drop a parent's pool would be to wait for its threads to end.
            std::mem::forget(kept.replace((own, pool.clone())));
            pool.clone()
        }
    });
    Ok(current.unwrap_or(pool))
}

/// Looks at the pool that is kept; `None` where the lock was lost in a fork.
fn with_pool<T>(look: impl FnOnce(&mut Kept) -> T) -> Option<T> {
    let begun = Instant::now();
    loop {
        match POOL.try_lock() {
            Ok(mut kept) => return Some(look(&mut kept)),
            Err(TryLockError::Poisoned(poisoned)) => {
                return Some(look(&mut poisoned.into_inner()));
            }
            Err(TryLockError::WouldBlock) if begun.elapsed() > MAX_LOCK_WAIT => return None,
            Err(TryLockError::WouldBlock) => std::thread::yield_now(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_process_has_one_pool_and_another_process_its_own() {
        let first = thread_pool().unwrap();
        assert!(Arc::ptr_eq(&first, &thread_pool().unwrap()));
        // As after a fork: the pool that is kept belongs to another process.
        with_pool(|kept| *kept = Some((0, first.clone())));
        let own = thread_pool().unwrap();
        assert!(!Arc::ptr_eq(&first, &own));
        assert_eq!(own.install(rayon::current_num_threads), first.install(rayon::current_num_threads));
        // A lock that is never given back must not stop the process.
        let held = POOL.lock().unwrap();
        assert!(thread_pool().is_ok());
        drop(held);
        assert!(Arc::ptr_eq(&own, &thread_pool().unwrap()));
    }
}
