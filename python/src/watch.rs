//! Progress reports to a Python callable, and Ctrl-C from Python.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

use pyo3::prelude::*;
use rayon::{ThreadPool, current_thread_index};
use trundle_estimate::EstimateError;
use trundle_infer::{InferError, Progress, Stage, Watch};
use trundle_mechanism::MechanismError;
use trundle_paper::PaperError;
use trundle_posterior::PosteriorError;

use crate::error::{refused, run_here};
use crate::pool::pool;

/// Interval between checks for signals.
const SIGNAL_CHECK_INTERVAL: Duration = Duration::from_millis(50);

/// Forwards progress to a Python callable and checks for signals.
struct Watcher {
    callback: Option<Py<PyAny>>,
    progress: Mutex<Progress>,
    last_check: Mutex<Instant>,
    raised: Mutex<Option<PyErr>>,
}

impl Watcher {
    /// Keeps the first exception. Returns whether there is one, which stops the work.
    fn keep(&self, result: PyResult<()>) -> bool {
        let Ok(mut raised) = self.raised.lock() else { return true };
        if let (Err(error), true) = (result, raised.is_none()) {
            *raised = Some(error);
        }
        raised.is_some()
    }
}

impl Watch for Watcher {
    fn progress(&self, what: &str, done: f64) {
        let Ok((stage, share)) = self.progress.lock().map(|mut progress| progress.advance(what, done)) else {
            return;
        };
        if let Some(callback) = &self.callback {
            self.keep(Python::attach(|py| callback.call1(py, (stage, share)).map(|_| ())));
        }
    }

    fn cancelled(&self) -> bool {
        let due = self.last_check.lock().is_ok_and(|mut last_check| {
            let due = last_check.elapsed() > SIGNAL_CHECK_INTERVAL;
            if due {
                *last_check = Instant::now();
            }
            due
        });
        if due { self.keep(Python::attach(|py| py.check_signals())) } else { self.keep(Ok(())) }
    }
}

/// The single stage of work that reports progress from 0 to 1 once.
pub(crate) const fn once(name: &'static str) -> [Stage; 1] {
    [Stage { name, end: 1.0, rounds: 1.0 }]
}

/// Longest wait of the calling thread for news, before it checks for signals.
const MAX_WAIT: Duration = Duration::from_millis(20);

/// Forwards progress to the calling thread, and its request to stop to the work.
struct Relay<'a> {
    news: Sender<(String, f64)>,
    stop: &'a AtomicBool,
}

impl Watch for Relay<'_> {
    fn progress(&self, what: &str, done: f64) {
        // The calling thread receives messages until the work ends.
        let _ = self.news.send((what.to_owned(), done));
    }

    fn cancelled(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

/// Runs interruptible `work` on the thread pool of the calling thread with the interpreter released. An exception of the
/// callback or Ctrl-C stops the work and is raised again. The callback receives the stage and the completed share of
/// the whole work, both of which never decrease.
pub(crate) fn watched<T: Send>(
    py: Python<'_>,
    callback: Option<Py<PyAny>>,
    stages: &'static [Stage],
    work: impl FnOnce(&dyn Watch) -> Result<T, InferError> + Send,
) -> PyResult<T> {
    let pool = pool().map_err(refused)?;
    let watcher = Watcher {
        callback,
        progress: Mutex::new(Progress::new(stages)),
        last_check: Mutex::new(Instant::now()),
        raised: Mutex::new(None),
    };
    let shared = &watcher;
    let result = run_here(py, move || match on_pool(&pool, shared, work) {
        Err(InferError::Interrupted) => Ok(None),
        other => other.map(Some),
    })?;
    match (result, watcher.raised.into_inner().ok().flatten()) {
        (Some(value), None) => Ok(value),
        (_, Some(raised)) => Err(raised),
        (None, None) => Err(refused(InferError::Interrupted)),
    }
}

/// Errors that include an interrupt by the user.
pub(crate) trait Interruptible: std::fmt::Display + Send {
    /// Whether the user interrupted the work.
    fn is_interrupt(&self) -> bool;
}

impl Interruptible for EstimateError {
    fn is_interrupt(&self) -> bool {
        self.is_interrupt()
    }
}

impl Interruptible for MechanismError {
    fn is_interrupt(&self) -> bool {
        self.is_interrupt()
    }
}

impl Interruptible for PaperError {
    fn is_interrupt(&self) -> bool {
        self.is_interrupt()
    }
}

impl Interruptible for PosteriorError {
    fn is_interrupt(&self) -> bool {
        self.is_interrupt()
    }
}

/// [`watched`] for work with errors of its own.
pub(crate) fn watched_request<T: Send, E: Interruptible>(
    py: Python<'_>,
    callback: Option<Py<PyAny>>,
    stages: &'static [Stage],
    work: impl FnOnce(&dyn Watch) -> Result<T, E> + Send,
) -> PyResult<T> {
    let result = watched(py, callback, stages, |watch| match work(watch) {
        Err(error) if error.is_interrupt() => Err(InferError::Interrupted),
        other => Ok(other),
    })?;
    result.map_err(refused)
}

/// Runs `work` on the pool, while the calling thread checks `watch`. Python handles signals only in its main thread.
fn on_pool<T: Send>(
    pool: &ThreadPool,
    watch: &Watcher,
    work: impl FnOnce(&dyn Watch) -> Result<T, InferError> + Send,
) -> Result<T, InferError> {
    // Called from a callback of other work: this thread belongs to a pool that may have no other threads.
    if current_thread_index().is_some() {
        return work(watch);
    }
    let (stop, mut result) = (AtomicBool::new(false), Err(InferError::Interrupted));
    let (news, received) = channel();
    let (relay, place) = (Relay { news, stop: &stop }, &mut result);
    pool.in_place_scope(|scope| {
        scope.spawn(move |_| *place = work(&relay));
        loop {
            match received.recv_timeout(MAX_WAIT) {
                Ok((what, done)) => watch.progress(&what, done),
                Err(RecvTimeoutError::Timeout) => {}
                // The work has ended and dropped the relay.
                Err(RecvTimeoutError::Disconnected) => break,
            }
            if watch.cancelled() {
                stop.store(true, Ordering::Relaxed);
            }
        }
    });
    result
}
