//! Online estimation from prepared pushes.

use trundle_diagnose::for_recording;
use trundle_infer::{Comparison, InferError, MotionLikelihood, Online, OnlineOptions};
use trundle_model::Model;
use trundle_record::{Dataset, Prepared};

/// An online estimate whose model follows from the first push.
pub struct OnlineEstimator {
    model: Option<Model>,
    options: OnlineOptions,
    /// Created by the first push, which determines the body.
    estimate: Option<Online>,
    /// Whether a push was fast enough to be compared by its motion. All later pushes are then compared so.
    compares_motion: bool,
}

impl OnlineEstimator {
    /// An estimator of a model; by default of the nominal model of the first push.
    pub fn new(model: Option<Model>, options: OnlineOptions) -> Self {
        Self { model, options, estimate: None, compares_motion: false }
    }

    /// Adds every episode of `data` as a completed push.
    ///
    /// # Errors
    /// If a push has too few data.
    pub fn update(&mut self, data: &Dataset) -> Result<(), InferError> {
        for push in data.episodes() {
            let comparison = self.comparison(data, push)?;
            self.estimate_for(data).update(Box::new(comparison))?;
        }
        Ok(())
    }

    /// Replaces the data of the current, incomplete push.
    ///
    /// # Errors
    /// If the push has too few data.
    pub fn peek(&mut self, data: &Dataset) -> Result<(), InferError> {
        for push in data.episodes() {
            let comparison = self.comparison(data, push)?;
            self.estimate_for(data).peek(&comparison)?;
        }
        Ok(())
    }

    /// Discards the current push.
    pub fn discard_current(&mut self) {
        match &mut self.estimate {
            Some(estimate) if estimate.pushes() > 0 => estimate.discard_current(),
            estimate => *estimate = None,
        }
    }

    /// The estimate; `None` before the first push.
    pub fn estimate(&self) -> Option<&Online> {
        self.estimate.as_ref()
    }

    fn estimate_for(&mut self, data: &Dataset) -> &mut Online {
        let (model, options) = (&self.model, &self.options);
        self.estimate.get_or_insert_with(|| Online::new(for_recording(data, model.as_ref()), options.clone()))
    }

    fn comparison(&mut self, data: &Dataset, push: &Prepared) -> Result<Comparison, InferError> {
        let push = std::slice::from_ref(push);
        if self.compares_motion {
            return MotionLikelihood::new(push, &data.noise).map(Comparison::Motion);
        }
        let comparison = Comparison::over(data, push)?;
        self.compares_motion = !comparison.is_quasi_static();
        Ok(comparison)
    }
}
