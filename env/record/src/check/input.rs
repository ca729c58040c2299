//! Input of the checks.

use super::data::RecordingData;
use super::wrench_fit::{WrenchFits, fit_wrench};
use crate::prepare::Dataset;
use crate::recording::Recording;

/// A recording and the results that several checks share.
pub(crate) struct CheckInput<'a> {
    /// The recording, prepared.
    pub data: RecordingData<'a>,
    /// Fits of the wrench by the motion; `None` if there is too little motion.
    pub wrench_fits: Option<WrenchFits>,
}

impl<'a> CheckInput<'a> {
    pub fn new(recording: &'a Recording, dataset: &'a Dataset) -> Self {
        let data = RecordingData::new(recording, dataset);
        Self { wrench_fits: fit_wrench(&data), data }
    }
}
