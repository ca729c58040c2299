//! Progress reports to a Python callable, and Ctrl-C from Python.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

use pyo3::prelude::*;
use rayon::{ThreadPool, current_thread_index};
use trundle_infer::{InferError, Progress, Stage, Watch};
use trundle_sim::thread_pool;

use crate::error::{refused, run_here};

/// How often Python is asked whether to go on.
const PATIENCE: Duration = Duration::from_millis(50);

/// Watches on behalf of Python.
struct Watcher {
    callback: Option<Py<PyAny>>,
    course: Mutex<Progress>,
    asked: Mutex<Instant>,
    raised: Mutex<Option<PyErr>>,
}

impl Watcher {
    /// Keep the first exception; the work stops at the next question.
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
        let Ok((stage, share)) = self.course.lock().map(|mut course| course.advance(what, done)) else {
            return;
        };
        if let Some(callback) = &self.callback {
            self.keep(Python::attach(|py| callback.call1(py, (stage, share)).map(|_| ())));
        }
    }

    fn cancelled(&self) -> bool {
        let due = self.asked.lock().is_ok_and(|mut asked| {
            let due = asked.elapsed() > PATIENCE;
            if due {
                *asked = Instant::now();
            }
            due
        });
        if due { self.keep(Python::attach(|py| py.check_signals())) } else { self.keep(Ok(())) }
    }
}

/// Stages of work that reports from 0 to 1 once.
pub(crate) const fn once(name: &'static str) -> [Stage; 1] {
    [Stage { name, end: 1.0, rounds: 1.0 }]
}

/// How often the calling thread looks after work that others do.
const LOOK: Duration = Duration::from_millis(20);

/// Carries progress to the calling thread, and its wish to stop to the work.
struct Relay<'a> {
    news: Sender<(String, f64)>,
    stop: &'a AtomicBool,
}

impl Watch for Relay<'_> {
    fn progress(&self, what: &str, done: f64) {
        // The calling thread hears all until the work has ended.
        let _ = self.news.send((what.to_owned(), done));
    }

    fn cancelled(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

/// Runs interruptible `work` on the thread pool of this process with the interpreter released; an exception of the
/// callback or Ctrl-C ends it and is raised again. The callback is called with the stage and the share of the whole,
/// neither of which ever goes back.
pub(crate) fn watched<T: Send>(
    py: Python<'_>,
    callback: Option<Py<PyAny>>,
    stages: &'static [Stage],
    work: impl FnOnce(&dyn Watch) -> Result<T, InferError> + Send,
) -> PyResult<T> {
    let pool = thread_pool().map_err(refused)?;
    let watcher = Watcher {
        callback,
        course: Mutex::new(Progress::new(stages)),
        asked: Mutex::new(Instant::now()),
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

/// Lets `work` run on the pool, while the calling thread, the only one in which Python handles signals, asks `watch`.
fn on_pool<T: Send>(
    pool: &ThreadPool,
    watch: &Watcher,
    work: impl FnOnce(&dyn Watch) -> Result<T, InferError> + Send,
) -> Result<T, InferError> {
    // A callback of other work: this thread is one of a pool, which may have no other.
    if current_thread_index().is_some() {
        return work(watch);
    }
    let (stop, mut result) = (AtomicBool::new(false), Err(InferError::Interrupted));
    let (news, heard) = channel();
    let (relay, place) = (Relay { news, stop: &stop }, &mut result);
    pool.in_place_scope(|scope| {
        scope.spawn(move |_| *place = work(&relay));
        loop {
            match heard.recv_timeout(LOOK) {
                Ok((what, done)) => watch.progress(&what, done),
                Err(RecvTimeoutError::Timeout) => {}
                // The work, and with it the relay, has ended.
                Err(RecvTimeoutError::Disconnected) => break,
            }
            if watch.cancelled() {
                stop.store(true, Ordering::Relaxed);
            }
        }
    });
    result
}
