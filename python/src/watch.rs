//! Progress to a Python callable, and Ctrl-C from it.

use std::sync::Mutex;
use std::time::{Duration, Instant};

use pyo3::prelude::*;
use trundle_infer::{InferError, Watch};

use crate::error::{refused, run};

/// How often Python is asked whether to go on.
const PATIENCE: Duration = Duration::from_millis(50);

/// Watches on behalf of Python.
struct Watcher {
    callback: Option<Py<PyAny>>,
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
        if let Some(callback) = &self.callback {
            self.keep(Python::attach(|py| callback.call1(py, (what, done)).map(|_| ())));
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

/// Runs interruptible `work` with the interpreter released; an exception of the callback or Ctrl-C ends it and
/// is raised again.
pub(crate) fn watched<T: Send>(
    py: Python<'_>,
    callback: Option<Py<PyAny>>,
    work: impl FnOnce(&dyn Watch) -> Result<T, InferError> + Send,
) -> PyResult<T> {
    let watcher = Watcher { callback, asked: Mutex::new(Instant::now()), raised: Mutex::new(None) };
    let shared = &watcher;
    let result = run(py, move || match work(shared) {
        Err(InferError::Interrupted) => Ok(None),
        other => other.map(Some),
    })?;
    match (result, watcher.raised.into_inner().ok().flatten()) {
        (Some(value), None) => Ok(value),
        (_, Some(raised)) => Err(raised),
        (None, None) => Err(refused(InferError::Interrupted)),
    }
}
