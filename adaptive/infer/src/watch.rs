//! Progress reports and cancellation of long work.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// Receives progress and decides whether to continue.
pub trait Watch: Sync {
    /// Reports that `what` has reached the share `done` (0 to 1).
    fn progress(&self, what: &str, done: f64);
    /// Whether the user asks to stop. Called often, on the calling thread only.
    fn cancelled(&self) -> bool;
}

/// Ignores progress and never cancels.
pub struct Quiet;

impl Watch for Quiet {
    fn progress(&self, _what: &str, _done: f64) {}
    fn cancelled(&self) -> bool {
        false
    }
}

/// Interval at which the calling thread polls the workers.
const POLL_INTERVAL: Duration = Duration::from_millis(20);

/// Runs `work` on all cores. Progress and cancellation are relayed to the calling thread, the only one that
/// calls `watch`.
pub fn on_all_cores<T: Send>(watch: &dyn Watch, work: impl FnOnce(&dyn Watch) -> T + Send) -> T {
    // A worker that waits for other workers could wait for itself; it already runs on the pool.
    if rayon::current_thread_index().is_some() {
        return work(watch);
    }
    let relay = Relay { stop: AtomicBool::new(false), report: Mutex::new(None) };
    let (done, finished) = channel();
    std::thread::scope(|scope| {
        let shared = &relay;
        let worker = scope.spawn(move || {
            let result = work(shared);
            let _ = done.send(());
            result
        });
        while finished.recv_timeout(POLL_INTERVAL) == Err(RecvTimeoutError::Timeout) {
            if watch.cancelled() {
                relay.stop.store(true, Ordering::Relaxed);
            }
            if let Some((what, share)) = relay.report.lock().ok().and_then(|mut report| report.take()) {
                watch.progress(&what, share);
            }
        }
        match worker.join() {
            Ok(result) => result,
            Err(panic) => std::panic::resume_unwind(panic),
        }
    })
}

/// Relays progress and cancellation between threads.
struct Relay {
    stop: AtomicBool,
    report: Mutex<Option<(String, f64)>>,
}

impl Watch for Relay {
    fn progress(&self, what: &str, done: f64) {
        if let Ok(mut report) = self.report.lock() {
            *report = Some((what.to_owned(), done));
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
