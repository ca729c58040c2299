//! Arguments that several functions share.

use pyo3::prelude::*;
use trundle_model::{Model, PriorFile};
use trundle_record::{Dataset, prepare};

use crate::error::{refused, run};
use crate::model::PyModel;
use crate::record::recording_of;

/// A prior file: its name for messages, and its content.
pub(crate) type PriorText = (String, String);

/// The prepared recording.
pub(crate) fn dataset(recording: &Bound<'_, PyAny>) -> PyResult<Dataset> {
    let source = recording_of(recording)?;
    run(recording.py(), || prepare(&source))
}

/// The laws and values of an optional model, without its posterior.
pub(crate) fn model(given: Option<PyRef<'_, PyModel>>) -> Option<Model> {
    given.map(|given| given.model.clone())
}

/// The prior in the content of a prior file.
pub(crate) fn prior(text: Option<PriorText>) -> PyResult<Option<PriorFile>> {
    text.map(|(name, text)| PriorFile::from_toml(&text, &name)).transpose().map_err(refused)
}
