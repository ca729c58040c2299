//! The estimate kept up to date push by push, at a cost that does not grow with their number.
//!
//! Each push is remembered as a quadratic in `z`, the expansion of its likelihood where the estimate stood
//! (information form of the extended Kalman filter; Bell 1994, "The iterated Kalman smoother as a Gauss-Newton
//! method"). A new push moves the mode by a few Gauss-Newton steps on its own likelihood plus those quadratics; one
//! earlier push is then expanded anew at the mode, in rotation, so that the estimate comes to rest where the fit of
//! all pushes at once does. The first push is searched from several starts, and modes that it cannot tell apart
//! are followed side by side until one is enough.

mod hypothesis;
mod quadratic;

use crate::fit::{canonical, ladder, on_circle};
use crate::search::scout;
use crate::{Coordinates, Estimate, FitOptions, InferError, Likelihood, Quiet};
use hypothesis::{Hypothesis, Setting};
use nalgebra::{DMatrix, DVector};
use trundle_model::Model;

/// How much an update may do.
#[derive(Clone, Debug)]
pub struct OnlineOptions {
    /// Random starts at the first push.
    pub starts: usize,
    /// Their seed.
    pub seed: u64,
    /// Pushes kept to be looked at again; older ones stay as they were last seen.
    pub kept: usize,
    /// Gauss-Newton steps at each update.
    pub steps: usize,
}

impl Default for OnlineOptions {
    fn default() -> Self {
        Self { starts: 6, seed: 0, kept: 16, steps: 2 }
    }
}

/// Modes followed side by side.
const MODES: usize = 3;

/// Modes less likely than the best by this (in nats) are given up.
const HOPELESS: f64 = 12.0;

/// Steps from the end of a short search to the mode of the first push.
const FIRST_STEPS: usize = 20;

/// An estimate that grows with every push.
pub struct Online {
    model: Model,
    coordinates: Coordinates,
    options: OnlineOptions,
    kept: Vec<Box<dyn Likelihood + Send>>,
    hypotheses: Vec<Hypothesis>,
    /// The modes with what has been seen of the push that is under way.
    current: Option<Vec<Hypothesis>>,
    /// How often the push under way was looked at.
    peeks: usize,
    pushes: usize,
}

impl Online {
    /// Knowing the priors of `model`'s free parameters alone.
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

    /// Take a whole push in.
    ///
    /// # Errors
    /// When it can be evaluated nowhere near the prior, or does not fit the model.
    pub fn update(&mut self, push: Box<dyn Likelihood + Send>) -> Result<(), InferError> {
        let begun = self.current.take().unwrap_or_else(|| self.hypotheses.clone());
        self.peeks = 0;
        let (mut modes, steps) = self.begun(&*push, begun)?;
        let setting = Setting { model: &self.model, coordinates: &self.coordinates };
        for mode in &mut modes {
            let term = mode.follow(&setting, &*push, steps)?;
            mode.terms.push(term);
        }
        prune(&mut modes)?;
        self.kept.push(push);
        if let Err(error) = self.look_back(&mut modes) {
            self.kept.pop();
            return Err(error);
        }
        self.pushes += 1;
        self.forget(&mut modes);
        self.hypotheses = modes;
        Ok(())
    }

    /// Take in what has been seen so far of a push that is under way: it replaces what an earlier call said of the
    /// same push, and [`Online::update`] with the whole of it replaces both.
    ///
    /// # Errors
    /// As [`Online::update`].
    pub fn peek(&mut self, so_far: &dyn Likelihood) -> Result<(), InferError> {
        let begun = self.current.take().unwrap_or_else(|| self.hypotheses.clone());
        self.peeks += 1;
        let (mut modes, steps) = self.begun(so_far, begun)?;
        let setting = Setting { model: &self.model, coordinates: &self.coordinates };
        for mode in &mut modes {
            mode.follow(&setting, so_far, if self.pushes == 0 { steps } else { 1 })?;
        }
        prune(&mut modes)?;
        self.current = Some(modes);
        Ok(())
    }

    /// Forget what [`Online::peek`] was told of the push that is under way.
    pub fn abandon(&mut self) {
        (self.current, self.peeks) = (None, 0);
    }

    /// The modes to follow, and by how many steps: those known, or on the first push those that a search finds.
    fn begun(
        &self,
        push: &dyn Likelihood,
        known: Vec<Hypothesis>,
    ) -> Result<(Vec<Hypothesis>, usize), InferError> {
        // A push that has grown to twice its length may show a mode that the first samples did not.
        let grown = self.pushes == 0 && self.peeks.is_power_of_two();
        if !known.is_empty() && !grown {
            return Ok((known, self.options.steps));
        }
        let options =
            FitOptions { starts: self.options.starts, seed: self.options.seed, ..FitOptions::default() };
        let ladder = ladder(push, &self.model, &options)?;
        let (points, _) = scout(&ladder, &[], &options, &Quiet)?;
        // The same wheel under two descriptions is one mode.
        let named = |z: Vec<f64>| ladder.last().and_then(|target| canonical(target, &z)).unwrap_or(z);
        let points = points.into_iter().take(MODES).map(named);
        let modes = points.map(|z| Hypothesis::at(DVector::from_vec(z)));
        Ok((known.into_iter().chain(modes).collect(), FIRST_STEPS))
    }

    /// Expand one earlier push anew at each mode, in rotation.
    fn look_back(&self, modes: &mut [Hypothesis]) -> Result<(), InferError> {
        let earlier = self.kept.len() - 1;
        if earlier == 0 {
            return Ok(());
        }
        let again = self.pushes % earlier;
        let setting = Setting { model: &self.model, coordinates: &self.coordinates };
        for mode in modes {
            let term = setting.expand(&*self.kept[again], &mode.z)?;
            if term.cost.is_finite() {
                mode.terms[again] = term;
            }
            mode.settle(&setting);
        }
        Ok(())
    }

    /// Sum up the oldest push for good where more are kept than agreed.
    fn forget(&mut self, modes: &mut [Hypothesis]) {
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

    /// How many pushes were taken in.
    pub fn pushes(&self) -> usize {
        self.pushes
    }

    /// How many modes are still followed.
    pub fn hypotheses(&self) -> usize {
        self.modes().len()
    }

    /// Values of all slots at the best mode; the prior's medians before any push.
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

    /// The model with every value filled in.
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

    /// The free parameters; what the pushes so far do not hold, or what two modes contradict each other in, is not
    /// identified.
    pub fn estimate(&self) -> Vec<Estimate> {
        let (spread, slopes) = self.spread();
        let (values, modes) = (self.values(), self.modes());
        let one = |k: usize| {
            let (slot, sd) = (self.coordinates.slot(k), spread[(k, k)].max(0.0).sqrt());
            let z = modes.first().map_or(0.0, |m| m.z[k]);
            let information =
                modes.first().map_or(0.0, |m| m.precision[(k, k)]) - self.coordinates.prior_precision(k);
            let torn = modes.iter().any(|m| (m.z[k] - z).abs() > 3.0 * sd);
            let identified = self.coordinates.identified(k, sd) && !torn;
            Estimate {
                name: slot.name.clone(),
                unit: slot.unit,
                mean: values[self.coordinates.free()[k]],
                sd: sd * slopes[k].abs(),
                identified: identified && self.coordinates.strain(k, z, information).is_none(),
            }
        };
        (0..slopes.len()).map(one).collect()
    }

    /// Posterior covariance in `z` at the best mode, and the slopes of the values there.
    fn spread(&self) -> (DMatrix<f64>, Vec<f64>) {
        let n = self.coordinates.free().len();
        let best = self.modes().first();
        let z = best.map_or_else(|| vec![0.0; n], |m| m.z.as_slice().to_vec());
        let mut precision = best.map_or_else(|| DMatrix::zeros(n, n), |m| m.precision.clone());
        for k in 0..n {
            let prior = if best.is_some() { self.coordinates.prior_precision(k) } else { 0.0 };
            precision[(k, k)] += (self.coordinates.least_precision(k) - prior).max(0.0);
        }
        let spread = precision.cholesky().map_or_else(|| DMatrix::identity(n, n) * 1e6, |c| c.inverse());
        (spread, self.coordinates.values(&z).1)
    }
}

/// Best mode first; those that are the same or hopeless are left out.
fn prune(modes: &mut Vec<Hypothesis>) -> Result<(), InferError> {
    let starts = modes.len();
    modes.retain(|mode| mode.cost.is_finite());
    modes.sort_by(|a, b| a.evidence_cost().total_cmp(&b.evidence_cost()));
    let mut left: Vec<Hypothesis> = vec![];
    for mode in modes.drain(..) {
        let hopeless =
            left.first().is_some_and(|best| mode.evidence_cost() > best.evidence_cost() + HOPELESS);
        if !hopeless && !left.iter().any(|other| other.same(&mode)) {
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
    fn modes_that_coincide_or_are_hopeless_are_given_up() {
        let mut modes = vec![mode(5.0, 3.0), mode(0.0, 1.0), mode(0.1, 2.0), mode(-5.0, 40.0)];
        prune(&mut modes).unwrap();
        assert_eq!(modes.iter().map(|m| m.z[0]).collect::<Vec<_>>(), vec![0.0, 5.0]);
        assert!(prune(&mut vec![mode(0.0, f64::INFINITY)]).is_err());
    }
}
