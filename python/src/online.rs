//! Online estimation in Python.

use std::sync::Arc;

use pyo3::prelude::*;
use serde_json::json;
use trundle_infer::{Comparison, InferError, MotionLikelihood, Online, OnlineOptions};
use trundle_model::Model;
use trundle_record::{Dataset, Metadata, Prepared, Recording, prepare};

use crate::columns;
use crate::error::{refused, run};
use crate::model::PyModel;
use crate::plain::plain;
use crate::record::{PyRecording, metadata_of, recording_of};

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<OnlineEstimate>()
}

/// Grows with every push; see `trundle.Online`.
#[pyclass(name = "_Online", module = "trundle")]
struct OnlineEstimate {
    metadata: Metadata,
    model: Option<Model>,
    options: OnlineOptions,
    /// Made by the first push, which says what body it is.
    inner: Option<Online>,
    /// Whether a push was fast enough to be compared by its motion. From then on all are.
    moves: bool,
}

#[pymethods]
impl OnlineEstimate {
    #[new]
    #[pyo3(signature = (metadata, model=None, *, starts=6, seed=0, kept=16))]
    fn new(
        metadata: &Bound<'_, PyAny>,
        model: Option<PyRef<'_, PyModel>>,
        starts: usize,
        seed: u64,
        kept: usize,
    ) -> PyResult<Self> {
        Ok(Self {
            metadata: metadata_of(metadata)?,
            model: model.map(|model| model.model.clone()),
            options: OnlineOptions { starts, seed, kept, ..OnlineOptions::default() },
            inner: None,
            moves: false,
        })
    }

    /// Take in the columns of a whole push, or every episode of a recording, each a push.
    fn update(&mut self, push: &Bound<'_, PyAny>) -> PyResult<()> {
        let recording = self.recording(push)?;
        let data = run(push.py(), || prepare(&recording))?;
        run(push.py(), || {
            for push in data.episodes() {
                let comparison = self.comparison(&data, push)?;
                self.online(&data).update(Box::new(comparison))?;
            }
            Ok::<_, InferError>(())
        })
    }

    /// Take in the columns of the push under way so far.
    fn peek(&mut self, push: &Bound<'_, PyAny>) -> PyResult<()> {
        let recording = self.recording(push)?;
        let data = run(push.py(), || prepare(&recording))?;
        run(push.py(), || {
            for push in data.episodes() {
                let comparison = self.comparison(&data, push)?;
                self.online(&data).peek(&comparison)?;
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

    /// The free parameters: a dict for each.
    fn estimate<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let estimates = self.inner.as_ref().map(Online::estimate).unwrap_or_default();
        let rows = estimates.iter().map(|e| {
            let kept = |value: f64| e.identified.then_some(value);
            json!({"name": e.name, "mean": kept(e.mean), "sd": kept(e.sd), "unit": e.unit, "identifiable": e.identified})
        });
        plain(py, &rows.collect::<Vec<_>>())
    }

    /// The model with every value filled in; `None` before the first push.
    fn model(&self) -> PyResult<Option<PyModel>> {
        let filled = |online: &Online| {
            Ok(PyModel { model: online.model().map_err(refused)?, posterior: online.posterior() })
        };
        self.inner.as_ref().map(filled).transpose()
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
    fn recording(&self, push: &Bound<'_, PyAny>) -> PyResult<Arc<Recording>> {
        if push.is_instance_of::<PyRecording>() {
            return recording_of(push);
        }
        let episode = columns::from_mapping("push", push)?;
        Recording::new(self.metadata.clone(), vec![episode]).map(Arc::new).map_err(refused)
    }

    fn online(&mut self, data: &Dataset) -> &mut Online {
        let (model, options) = (&self.model, &self.options);
        self.inner.get_or_insert_with(|| {
            Online::new(trundle_diagnose::for_recording(data, model.as_ref()), options.clone())
        })
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
