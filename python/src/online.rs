//! The estimate that is kept up to date, in Python.

use pyo3::prelude::*;
use serde_json::json;
use trundle_infer::{Comparison, InferError, MotionLikelihood, Online, OnlineOptions};
use trundle_model::Model;
use trundle_record::{Dataset, Prepared};

use crate::error::{refused, run};
use crate::infer::inputs;

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<OnlineEstimate>()
}

/// Grows with every push; see `trundle.Online`.
#[pyclass(name = "_Online", module = "trundle")]
struct OnlineEstimate {
    model: Option<String>,
    options: OnlineOptions,
    /// Made by the first push, which says what body it is.
    inner: Option<Online>,
    /// A push was fast enough to be judged by its motion: from then on all are, and none is looked at for that.
    moves: bool,
}

#[pymethods]
impl OnlineEstimate {
    #[new]
    #[pyo3(signature = (model=None, *, starts=6, seed=0, kept=16))]
    fn new(model: Option<String>, starts: usize, seed: u64, kept: usize) -> Self {
        Self {
            model,
            options: OnlineOptions { starts, seed, kept, ..OnlineOptions::default() },
            inner: None,
            moves: false,
        }
    }

    /// Take in every episode of a recording, each a push.
    fn update(&mut self, recording: &Bound<'_, PyAny>) -> PyResult<()> {
        let (data, model) = inputs(recording, self.model.as_deref())?;
        run(recording.py(), || {
            for push in data.episodes() {
                let comparison = self.comparison(&data, push)?;
                self.online(&data, model.as_ref()).update(Box::new(comparison))?;
            }
            Ok::<_, InferError>(())
        })
    }

    /// Take in what has been seen so far of a push under way: the only episode of a recording.
    fn peek(&mut self, recording: &Bound<'_, PyAny>) -> PyResult<()> {
        let (data, model) = inputs(recording, self.model.as_deref())?;
        run(recording.py(), || {
            for push in data.episodes() {
                let comparison = self.comparison(&data, push)?;
                self.online(&data, model.as_ref()).peek(&comparison)?;
            }
            Ok::<_, InferError>(())
        })
    }

    /// Forget the push under way.
    fn abandon(&mut self) {
        match &mut self.inner {
            Some(online) if online.pushes() > 0 => online.discard_current(),
            inner => *inner = None,
        }
    }

    /// The free parameters, as JSON.
    fn estimate(&self) -> String {
        let estimates = self.inner.as_ref().map(Online::estimate).unwrap_or_default();
        let rows = estimates.iter().map(|e| {
            let kept = |value: f64| e.identified.then_some(value);
            json!({"name": e.name, "mean": kept(e.mean), "sd": kept(e.sd), "unit": e.unit, "identifiable": e.identified})
        });
        serde_json::Value::from(rows.collect::<Vec<_>>()).to_string()
    }

    /// model.toml with every value filled in; `None` before the first push.
    fn filled(&self) -> PyResult<Option<String>> {
        let text = |online: &Online| online.model()?.to_toml(None).map_err(InferError::from);
        self.inner.as_ref().map(text).transpose().map_err(refused)
    }

    #[getter]
    fn pushes(&self) -> usize {
        self.inner.as_ref().map_or(0, Online::pushes)
    }

    #[getter]
    fn hypotheses(&self) -> usize {
        self.inner.as_ref().map_or(0, Online::hypotheses)
    }
}

impl OnlineEstimate {
    fn online(&mut self, data: &Dataset, model: Option<&Model>) -> &mut Online {
        let options = self.options.clone();
        self.inner.get_or_insert_with(|| Online::new(trundle_diagnose::for_recording(data, model), options))
    }

    fn comparison(&mut self, data: &Dataset, push: &Prepared) -> Result<Comparison, InferError> {
        let push = std::slice::from_ref(push);
        if self.moves {
            return MotionLikelihood::new(push, &data.noise).map(Comparison::Motion);
        }
        let comparison = Comparison::over(data, push)?;
        self.moves = !comparison.is_quasi_static();
        Ok(comparison)
    }
}
