//! Online estimation in Python.

use std::sync::Arc;

use pyo3::prelude::*;
use serde_json::json;
use trundle_estimate::OnlineEstimator;
use trundle_infer::{Online, OnlineOptions};
use trundle_record::{Dataset, Metadata, Recording, prepare};

use crate::columns;
use crate::error::{refused, run};
use crate::model::PyModel;
use crate::plain::plain;
use crate::record::{PyRecording, metadata_of, recording_of};

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<OnlineEstimate>()
}

/// Online estimate; see `trundle.Online`.
#[pyclass(name = "_Online", module = "trundle")]
struct OnlineEstimate {
    metadata: Metadata,
    estimator: OnlineEstimator,
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
        let options = OnlineOptions { starts, seed, kept, ..OnlineOptions::default() };
        let estimator = OnlineEstimator::new(model.map(|model| model.model.clone()), options);
        Ok(Self { metadata: metadata_of(metadata)?, estimator })
    }

    /// Add a completed push, given by its columns, or every episode of a recording as a push.
    fn update(&mut self, push: &Bound<'_, PyAny>) -> PyResult<()> {
        let data = self.prepared(push)?;
        run(push.py(), || self.estimator.update(&data))
    }

    /// Replace the data of the current, incomplete push, given by its columns.
    fn peek(&mut self, push: &Bound<'_, PyAny>) -> PyResult<()> {
        let data = self.prepared(push)?;
        run(push.py(), || self.estimator.peek(&data))
    }

    /// Discard the current push.
    fn abandon(&mut self) {
        self.estimator.discard_current();
    }

    /// The free parameters: a dict for each.
    fn estimate<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let estimates = self.estimator.estimate().map(Online::estimate).unwrap_or_default();
        let rows = estimates.iter().map(|e| {
            let if_identified = |value: f64| e.identified.then_some(value);
            json!({
                "name": e.name, "mean": if_identified(e.mean), "sd": if_identified(e.sd), "unit": e.unit,
                "identifiable": e.identified,
            })
        });
        plain(py, &rows.collect::<Vec<_>>())
    }

    /// The model with all values; `None` before the first push.
    fn model(&self) -> PyResult<Option<PyModel>> {
        let fitted = |online: &Online| {
            Ok(PyModel { model: online.model().map_err(refused)?, posterior: online.posterior() })
        };
        self.estimator.estimate().map(fitted).transpose()
    }

    /// Number of completed pushes.
    #[getter]
    fn pushes(&self) -> usize {
        self.estimator.estimate().map_or(0, Online::pushes)
    }

    /// Number of hypotheses about the parameters.
    #[getter]
    fn hypotheses(&self) -> usize {
        self.estimator.estimate().map_or(0, Online::hypotheses)
    }
}

impl OnlineEstimate {
    /// The prepared push or recording.
    fn prepared(&self, push: &Bound<'_, PyAny>) -> PyResult<Dataset> {
        let recording = if push.is_instance_of::<PyRecording>() {
            recording_of(push)?
        } else {
            let episode = columns::from_mapping("push", push)?;
            Arc::new(Recording::new(self.metadata.clone(), vec![episode]).map_err(refused)?)
        };
        run(push.py(), || prepare(&recording))
    }
}
