//! How long work says where it is, and learns that it should stop.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// Told of progress, asked whether to go on.
pub trait Watch: Sync {
    /// Work has come to `done` (0 to 1) of `what`.
    fn progress(&self, what: &str, done: f64);
    /// Whether the user wants it to stop; asked often, on the calling thread only.
    fn cancelled(&self) -> bool;
}

/// Says nothing, never stops.
pub struct Quiet;

impl Watch for Quiet {
    fn progress(&self, _what: &str, _done: f64) {}
    fn cancelled(&self) -> bool {
        false
    }
}

/// Between two looks of the calling thread at work that others do.
const LOOK: Duration = Duration::from_millis(20);

/// Let `work` use all cores: what it reports and asks goes through the calling thread, the only one that
/// may call `watch`.
pub fn on_all_cores<T: Send>(watch: &dyn Watch, work: impl FnOnce(&dyn Watch) -> T + Send) -> T {
    // A worker that waits for other workers may wait for itself; it is one of all cores already.
    if rayon::current_thread_index().is_some() {
        return work(watch);
    }
    let relay = Relay { stop: AtomicBool::new(false), news: Mutex::new(None) };
    let (done, finished) = channel();
    std::thread::scope(|scope| {
        let shared = &relay;
        let worker = scope.spawn(move || {
            let result = work(shared);
            let _ = done.send(());
            result
        });
        while finished.recv_timeout(LOOK) == Err(RecvTimeoutError::Timeout) {
            if watch.cancelled() {
                relay.stop.store(true, Ordering::Relaxed);
            }
            if let Some((what, share)) = relay.news.lock().ok().and_then(|mut news| news.take()) {
                watch.progress(&what, share);
            }
        }
        match worker.join() {
            Ok(result) => result,
            Err(panic) => std::panic::resume_unwind(panic),
        }
    })
}

/// Carries progress and the wish to stop between threads.
struct Relay {
    stop: AtomicBool,
    news: Mutex<Option<(String, f64)>>,
}

impl Watch for Relay {
    fn progress(&self, what: &str, done: f64) {
        if let Ok(mut news) = self.news.lock() {
            *news = Some((what.to_owned(), done));
        }
    }

    fn cancelled(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayon::prelude::*;

    #[test]
    fn workers_may_use_all_cores_too() {
        let squares =
            |n: usize| on_all_cores(&Quiet, |_| (0..n).into_par_iter().map(|k| k * k).sum::<usize>());
        let sums: Vec<usize> = (0..64).into_par_iter().map(squares).collect();
        assert_eq!(sums[63], (0..63).map(|k| k * k).sum::<usize>());
    }
}
