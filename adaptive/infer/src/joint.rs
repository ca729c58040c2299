//! Joint likelihood of several recordings of one object.

use crate::likelihood::{Evaluation, Likelihood, Linearised};
use crate::{Channels, InferError};
use trundle_model::{Model, Slot};

/// Sum of likelihoods. Each recording keeps its own noise, frames and rates.
pub struct Joint<'a> {
    parts: Vec<Box<dyn Likelihood + 'a>>,
}

impl<'a> Joint<'a> {
    /// Joins at least one likelihood.
    ///
    /// # Errors
    /// When `parts` is empty.
    pub fn new(parts: Vec<Box<dyn Likelihood + 'a>>) -> Result<Self, InferError> {
        if parts.is_empty() {
            return Err(InferError::NoData {
                recording: "the fit".to_owned(),
                reason: "no recording is given".to_owned(),
                remedy: "give at least one recording".to_owned(),
            });
        }
        Ok(Self { parts })
    }
}

impl Likelihood for Joint<'_> {
    fn cost(&self, model: &Model, values: &[f64]) -> Result<f64, InferError> {
        self.parts.iter().map(|part| part.cost(model, values)).sum()
    }

    fn linearise(&self, model: &Model, values: &[f64], free: &[usize]) -> Result<Linearised, InferError> {
        let parts = self.parts.iter().map(|part| part.linearise(model, values, free));
        Ok(Linearised::sum(free.len(), parts.collect::<Result<Vec<_>, _>>()?))
    }

    fn evaluate<'a>(
        &'a self,
        model: &'a Model,
        values: &[f64],
        free: &'a [usize],
        likely: bool,
    ) -> Result<Evaluation<'a>, InferError> {
        let evaluations = self.parts.iter().map(|part| part.evaluate(model, values, free, likely));
        let evaluations = evaluations.collect::<Result<Vec<_>, _>>()?;
        let cost = evaluations.iter().map(|evaluation| evaluation.cost).sum();
        Ok(Evaluation::new(cost, move || {
            let parts = evaluations.into_iter().map(Evaluation::linearise);
            Ok(Linearised::sum(free.len(), parts.collect::<Result<Vec<_>, _>>()?))
        }))
    }

    fn chi_squared(&self, model: &Model, values: &[f64]) -> Result<(f64, usize), InferError> {
        self.parts.iter().try_fold((0.0, 0), |(sum, count), part| {
            let (own, residuals) = part.chi_squared(model, values)?;
            Ok((sum + own, count + residuals))
        })
    }

    /// Noise of the first recording.
    fn channels(&self) -> Channels {
        self.parts[0].channels()
    }

    /// Noise parameters of the first recording. Recordings share the scatter.
    fn noise(&self) -> Vec<Slot> {
        self.parts[0].noise()
    }

    fn split(&self) -> Vec<(String, Box<dyn Likelihood + '_>)> {
        self.parts.iter().flat_map(|part| part.split()).collect()
    }

    fn tuned(&self, model: &Model, values: &[f64]) -> Result<Option<Box<dyn Likelihood + '_>>, InferError> {
        let tuned = self
            .parts
            .iter()
            .map(|part| part.tuned(model, values))
            .collect::<Result<Vec<_>, InferError>>()?;
        if tuned.iter().all(Option::is_none) {
            return Ok(None);
        }
        let parts = tuned
            .into_iter()
            .zip(&self.parts)
            .map(|(tuned, part)| tuned.unwrap_or_else(|| Box::new(Borrowed(&**part))))
            .collect();
        Ok(Some(Box::new(Joint { parts })))
    }
}

/// A borrowed likelihood.
struct Borrowed<'a>(&'a dyn Likelihood);

impl Likelihood for Borrowed<'_> {
    fn cost(&self, model: &Model, values: &[f64]) -> Result<f64, InferError> {
        self.0.cost(model, values)
    }

    fn linearise(&self, model: &Model, values: &[f64], free: &[usize]) -> Result<Linearised, InferError> {
        self.0.linearise(model, values, free)
    }

    fn evaluate<'a>(
        &'a self,
        model: &'a Model,
        values: &[f64],
        free: &'a [usize],
        likely: bool,
    ) -> Result<Evaluation<'a>, InferError> {
        self.0.evaluate(model, values, free, likely)
    }

    fn chi_squared(&self, model: &Model, values: &[f64]) -> Result<(f64, usize), InferError> {
        self.0.chi_squared(model, values)
    }

    fn channels(&self) -> Channels {
        self.0.channels()
    }

    fn noise(&self) -> Vec<Slot> {
        self.0.noise()
    }

    fn split(&self) -> Vec<(String, Box<dyn Likelihood + '_>)> {
        self.0.split()
    }

    fn tuned(&self, model: &Model, values: &[f64]) -> Result<Option<Box<dyn Likelihood + '_>>, InferError> {
        self.0.tuned(model, values)
    }
}
