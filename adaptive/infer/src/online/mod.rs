//! Recursive estimation: an estimate updated push by push, at a cost that does not grow with their number.
//!
//! Each push is stored as a quadratic in `z`, the expansion of its −log likelihood at the estimate
//! (information form of the extended Kalman filter; Bell 1994, "The iterated Kalman smoother as a
//! Gauss-Newton method"). A new push moves the mode by a few Gauss-Newton steps on its own likelihood plus
//! those quadratics. One earlier push, in rotation, is then linearised again at the mode, so that the
//! estimate converges to that of a joint fit. The first push is searched from several starts. Several modes
//! that it cannot distinguish are tracked until one remains.

mod hypothesis;
mod quadratic;

use crate::fit::{canonical, continuation, on_circle};
use crate::search::search_starts;
use crate::{Coordinates, Estimate, FitOptions, InferError, Likelihood, Quiet, Target};
use hypothesis::{Hypothesis, Setting};
use nalgebra::{DMatrix, DVector};
use std::collections::BTreeSet;
use trundle_model::{Model, Posterior};

/// Settings of recursive estimation.
#[derive(Clone, Debug)]
pub struct OnlineOptions {
    /// Number of random starts for the first push.
    pub starts: usize,
    /// Seed of the random starts.
    pub seed: u64,
    /// Number of retained pushes that are linearised again; older ones keep their last expansion.
    pub kept: usize,
    /// Maximum number of Gauss-Newton steps per update.
    pub steps: usize,
}

impl Default for OnlineOptions {
    fn default() -> Self {
        Self { starts: 6, seed: 0, kept: 16, steps: 2 }
    }
}

/// Maximum number of tracked modes.
const MAX_MODES: usize = 3;

/// Modes whose −log evidence exceeds that of the best by more than this are dropped, nats.
const MAX_EVIDENCE_LOSS_NATS: f64 = 12.0;

/// Maximum number of steps from the end of a short search to the mode of the first push.
const MAX_FIRST_STEPS: usize = 20;

/// The same for later searches during the first push. It bounds the cost of an update; the next ones continue.
const MAX_LATER_STEPS: usize = 2;

/// An estimate updated with every push.
pub struct Online {
    model: Model,
    coordinates: Coordinates,
    options: OnlineOptions,
    kept: Vec<Box<dyn Likelihood + Send>>,
    hypotheses: Vec<Hypothesis>,
    /// The modes including the data so far of the current push.
    current: Option<Vec<Hypothesis>>,
    /// Number of calls of [`Online::peek`] in the current push.
    peeks: usize,
    pushes: usize,
}

impl Online {
    /// Starts from the priors of `model`'s free parameters.
    pub fn new(model: Model, options: OnlineOptions) -> Self {
        let coordinates = Coordinates::new(&model);
        Self {
            model,
            coordinates,
            options,
            kept: vec![],
            hypotheses: vec![],
            current: None,
            peeks: 0,
            pushes: 0,
        }
    }

    /// Add a complete push.
    ///
    /// # Errors
    /// When the push cannot be evaluated near the prior, or does not match the model.
    pub fn update(&mut self, push: Box<dyn Likelihood + Send>) -> Result<(), InferError> {
        let known = self.current.take().unwrap_or_else(|| self.hypotheses.clone());
        self.peeks = 0;
        let (mut modes, steps) = self.modes_to_track(&*push, known)?;
        let setting = Setting { model: &self.model, coordinates: &self.coordinates };
        for mode in &mut modes {
            let term = mode.add_push(&setting, &*push, steps)?;
            mode.terms.push(term);
        }
        prune(&mut modes)?;
        self.kept.push(push);
        if let Err(error) = self.relinearise_one(&mut modes) {
            self.kept.pop();
            return Err(error);
        }
        self.pushes += 1;
        self.drop_oldest(&mut modes);
        self.hypotheses = modes;
        Ok(())
    }

    /// Update the estimate with the data so far of the current push. It replaces an earlier call for the same
    /// push, and [`Online::update`] with the complete push replaces both.
    ///
    /// # Errors
    /// As [`Online::update`].
    pub fn peek(&mut self, so_far: &dyn Likelihood) -> Result<(), InferError> {
        let known = self.current.take().unwrap_or_else(|| self.hypotheses.clone());
        self.peeks += 1;
        let (mut modes, steps) = self.modes_to_track(so_far, known)?;
        let setting = Setting { model: &self.model, coordinates: &self.coordinates };
        for mode in &mut modes {
            mode.add_push(&setting, so_far, if self.pushes == 0 { steps } else { 1 })?;
        }
        prune(&mut modes)?;
        self.current = Some(modes);
        Ok(())
    }

    /// Discard the data of the current push given to [`Online::peek`].
    pub fn discard_current(&mut self) {
        (self.current, self.peeks) = (None, 0);
    }

    /// The modes to track and the number of steps. On the first push a search adds modes, and again whenever the
    /// push has doubled in length: its first samples may not show all modes.
    fn modes_to_track(
        &self,
        push: &dyn Likelihood,
        known: Vec<Hypothesis>,
    ) -> Result<(Vec<Hypothesis>, usize), InferError> {
        if self.pushes > 0 {
            return Ok((known, self.options.steps));
        }
        // Two descriptions of the same wheel are one mode.
        let target = Target::new(push, &self.model, &BTreeSet::new())?;
        let mode = |z: Vec<f64>| Hypothesis::at(DVector::from_vec(canonical(&target, &z).unwrap_or(z)));
        let mut modes: Vec<Hypothesis> =
            known.into_iter().map(|known| mode(known.z.as_slice().to_vec())).collect();
        if !modes.is_empty() && !self.peeks.is_power_of_two() {
            return Ok((modes, self.options.steps));
        }
        let options =
            FitOptions { starts: self.options.starts, seed: self.options.seed, ..FitOptions::default() };
        let continuation = continuation(push, &self.model, &options)?;
        let (points, _) = search_starts(&continuation, &[], &options, &Quiet)?;
        let steps = if modes.is_empty() { MAX_FIRST_STEPS } else { MAX_LATER_STEPS };
        modes.extend(points.into_iter().take(MAX_MODES).map(mode));
        Ok((modes, steps))
    }

    /// Linearises one earlier push again at each mode, in rotation.
    fn relinearise_one(&self, modes: &mut [Hypothesis]) -> Result<(), InferError> {
        let earlier = self.kept.len() - 1;
        if earlier == 0 {
            return Ok(());
        }
        let chosen = self.pushes % earlier;
        let setting = Setting { model: &self.model, coordinates: &self.coordinates };
        for mode in modes {
            let term = setting.expand(&*self.kept[chosen], &mode.z)?;
            if term.cost.is_finite() {
                mode.terms[chosen] = term;
            }
            mode.minimise(&setting);
        }
        Ok(())
    }

    /// Adds the oldest push to the sum of past pushes if too many are retained.
    fn drop_oldest(&mut self, modes: &mut [Hypothesis]) {
        if self.kept.len() <= self.options.kept.max(1) {
            return;
        }
        self.kept.remove(0);
        for mode in modes {
            let oldest = mode.terms.remove(0);
            mode.past = mode.past.moved(&mode.z);
            mode.past.add(&oldest);
        }
    }

    fn modes(&self) -> &[Hypothesis] {
        self.current.as_deref().unwrap_or(&self.hypotheses)
    }

    /// Number of pushes.
    pub fn pushes(&self) -> usize {
        self.pushes
    }

    /// Number of tracked modes.
    pub fn hypotheses(&self) -> usize {
        self.modes().len()
    }

    /// Values of all slots at the best mode; the prior medians before the first push.
    pub fn values(&self) -> Vec<f64> {
        let z = self
            .modes()
            .first()
            .map_or_else(|| vec![0.0; self.coordinates.free().len()], |m| m.z.as_slice().to_vec());
        let mut values = self.coordinates.values(&z).0;
        for (k, &slot) in self.coordinates.free().iter().enumerate() {
            values[slot] = on_circle(&self.coordinates.slot(k).prior, values[slot]);
        }
        values
    }

    /// The model with all values filled in.
    ///
    /// # Errors
    /// Never for values within their bounds.
    pub fn model(&self) -> Result<Model, InferError> {
        Ok(self.model.with_values(&self.values())?)
    }

    /// Covariance of the free parameters in their units, at the best mode.
    pub fn covariance(&self) -> DMatrix<f64> {
        let (spread, slopes) = self.spread();
        DMatrix::from_fn(slopes.len(), slopes.len(), |i, j| spread[(i, j)] * slopes[i] * slopes[j])
    }

    /// The posterior for `model.toml`, restricted to the identified parameters.
    pub fn posterior(&self) -> Option<Posterior> {
        let (estimates, covariance) = (self.estimate(), self.covariance());
        let kept: Vec<usize> = (0..estimates.len()).filter(|&k| estimates[k].identified).collect();
        (!kept.is_empty()).then(|| Posterior {
            names: kept.iter().map(|&k| estimates[k].name.clone()).collect(),
            mean: kept.iter().map(|&k| estimates[k].mean).collect(),
            covariance: kept.iter().map(|&i| kept.iter().map(|&j| covariance[(i, j)]).collect()).collect(),
        })
    }

    /// Estimates of the free parameters. A parameter is not identified if the pushes so far do not determine
    /// it, or if two modes disagree on it.
    pub fn estimate(&self) -> Vec<Estimate> {
        let (spread, slopes) = self.spread();
        let (values, modes) = (self.values(), self.modes());
        let one = |k: usize| {
            let (slot, sd) = (self.coordinates.slot(k), spread[(k, k)].max(0.0).sqrt());
            let z = modes.first().map_or(0.0, |m| m.z[k]);
            let information =
                modes.first().map_or(0.0, |m| m.precision[(k, k)]) - self.coordinates.prior_precision(k);
            let disagree = modes.iter().any(|m| (m.z[k] - z).abs() > 3.0 * sd);
            let identified = self.coordinates.identified(k, sd) && !disagree;
            Estimate {
                name: slot.name.clone(),
                unit: slot.unit,
                mean: values[self.coordinates.free()[k]],
                sd: sd * slopes[k].abs(),
                identified: identified && self.coordinates.prior_conflict(k, z, information).is_none(),
            }
        };
        (0..slopes.len()).map(one).collect()
    }

    /// Posterior covariance in `z` at the best mode, and the derivatives of the values there.
    fn spread(&self) -> (DMatrix<f64>, Vec<f64>) {
        let n = self.coordinates.free().len();
        let best = self.modes().first();
        let z = best.map_or_else(|| vec![0.0; n], |m| m.z.as_slice().to_vec());
        let mut precision = best.map_or_else(|| DMatrix::zeros(n, n), |m| m.precision.clone());
        for k in 0..n {
            let prior = if best.is_some() { self.coordinates.prior_precision(k) } else { 0.0 };
            precision[(k, k)] += (self.coordinates.min_precision(k) - prior).max(0.0);
        }
        let spread = precision.cholesky().map_or_else(|| DMatrix::identity(n, n) * 1e6, |c| c.inverse());
        (spread, self.coordinates.values(&z).1)
    }
}

/// Sorts the modes, best first, and drops duplicates and modes with negligible evidence.
fn prune(modes: &mut Vec<Hypothesis>) -> Result<(), InferError> {
    let starts = modes.len();
    modes.retain(|mode| mode.cost.is_finite());
    modes.sort_by(|a, b| a.evidence_cost().total_cmp(&b.evidence_cost()));
    let mut left: Vec<Hypothesis> = vec![];
    for mode in modes.drain(..) {
        let negligible = left
            .first()
            .is_some_and(|best| mode.evidence_cost() > best.evidence_cost() + MAX_EVIDENCE_LOSS_NATS);
        if !negligible && !left.iter().any(|other| other.is_same(&mode)) {
            left.push(mode);
        }
    }
    *modes = left;
    if modes.is_empty() {
        return Err(InferError::NoStart { recording: "the push".to_owned(), starts });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mode(z: f64, cost: f64) -> Hypothesis {
        Hypothesis { cost, ..Hypothesis::at(DVector::from_vec(vec![z])) }
    }

    #[test]
    fn duplicate_and_negligible_modes_are_dropped() {
        let mut modes = vec![mode(5.0, 3.0), mode(0.0, 1.0), mode(0.1, 2.0), mode(-5.0, 40.0)];
        prune(&mut modes).unwrap();
        assert_eq!(modes.iter().map(|m| m.z[0]).collect::<Vec<_>>(), vec![0.0, 5.0]);
        assert!(prune(&mut vec![mode(0.0, f64::INFINITY)]).is_err());
    }
}
