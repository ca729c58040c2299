//! Thread pool of the process, safe after a fork.

use std::sync::{Arc, Mutex, TryLockError};
use std::time::{Duration, Instant};

use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::SimError;

/// Stack size of each thread, bytes. It equals that of a main thread on Linux, so that work can move between them.
const THREAD_STACK_BYTES: usize = 8 << 20;

/// Longest wait for the lock. Threads hold it for less than a microsecond, unless a fork removed the holding thread.
const MAX_LOCK_WAIT: Duration = Duration::from_millis(100);

/// A thread pool with the id of the process that owns its threads.
type OwnedPool = Option<(u32, Arc<ThreadPool>)>;

static POOL: Mutex<OwnedPool> = Mutex::new(None);

/// Returns the thread pool of this process.
///
/// A forked child process has none of its parent's threads, so work in the parent's pool would wait forever. The pool is
/// therefore stored with the process id, and rebuilt if the id changes. Rayon's global pool cannot be rebuilt, so all
/// parallel work must run in this pool.
///
/// # Errors
/// If the system cannot create the threads.
pub fn thread_pool() -> Result<Arc<ThreadPool>, SimError> {
    let own = std::process::id();
    let known =
        with_pool(|kept| kept.as_ref().filter(|(process, _)| *process == own).map(|(_, p)| p.clone()));
    if let Some(pool) = known.flatten() {
        return Ok(pool);
    }
    let builder =
        ThreadPoolBuilder::new().stack_size(THREAD_STACK_BYTES).thread_name(|k| format!("trundle-{k}"));
    let pool = Arc::new(builder.build().map_err(|e| SimError::Threads(e.to_string()))?);
    let current = with_pool(|kept| match kept {
        // Another thread has built the pool in the meantime.
        Some((process, first)) if *process == own => first.clone(),
        _ => {
            // Dropping a parent's pool would wait for its threads to end.
            std::mem::forget(kept.replace((own, pool.clone())));
            pool.clone()
        }
    });
    Ok(current.unwrap_or(pool))
}

/// Access the stored pool. Returns `None` if a fork left the lock held.
fn with_pool<T>(look: impl FnOnce(&mut OwnedPool) -> T) -> Option<T> {
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
    fn each_process_has_its_own_pool() {
        let first = thread_pool().unwrap();
        assert!(Arc::ptr_eq(&first, &thread_pool().unwrap()));
        // As after a fork: the stored pool belongs to another process.
        with_pool(|kept| *kept = Some((0, first.clone())));
        let own = thread_pool().unwrap();
        assert!(!Arc::ptr_eq(&first, &own));
        assert_eq!(own.install(rayon::current_num_threads), first.install(rayon::current_num_threads));
        // A lock that is never released must not block the process.
        let held = POOL.lock().unwrap();
        assert!(thread_pool().is_ok());
        drop(held);
        assert!(Arc::ptr_eq(&own, &thread_pool().unwrap()));
    }
}
