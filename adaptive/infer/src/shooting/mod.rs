//! Likelihoods of simulated motion: simulations from a known state under the recorded wrench, compared with
//! the measured states.
//!
//! ```text
//! x'_i = g(x_i, u_i, δt_i; φ) + ε,   ε ~ σ · (normal or Student's t)          (eq. 5, 6)
//! ```
//! One type covers the paper's per-step displacement (eq. 8), its final integrated state (eq. 9), and
//! multiple shooting between the two. They differ in where the simulation restarts and which states are
//! compared ([`Cut`]). σ is estimated together with φ, with one value for each kind of channel. Residuals are
//! assumed independent, and the noise of the force is part of σ. Intervals are therefore narrower than those
//! of [`crate::MotionLikelihood`], which models both.

mod guided;
mod loss;
mod scatter;
mod segments;
mod slopes;

pub use guided::guided_fit;
pub use loss::Loss;
pub use scatter::Scatter;
pub use segments::Cut;

use crate::{Channels, InferError, Likelihood, Linearised, Transition};
use nalgebra::RowDVector;
use rayon::prelude::*;
use scatter::{LOG_SCATTER_SD, Sigma, difference, kind};
use segments::{Segment, of_episode, of_transition};
use slopes::{LawSimulation, Simulate, StepperSimulation};
use trundle_model::{Model, Slot, StepError, Stepper};
use trundle_record::{Noise, Prepared};

/// Compares simulated with measured states, segment by segment.
#[derive(Clone)]
pub struct Shooting<'a> {
    segments: Vec<Segment>,
    /// Names of the episodes.
    episodes: Vec<String>,
    /// Compared channels of [`crate::StateVector`].
    compared: Vec<usize>,
    sigma: Sigma,
    loss: Loss,
    channels: Channels,
    stepper: Option<&'a dyn Stepper>,
}

/// σ of each channel, with the index of its slot.
type Sigmas = [(f64, usize); 6];

/// Number of segments whose results are summed together. It is independent of the number of threads, so that
/// results are reproducible.
const SEGMENTS_PER_BATCH: usize = 8;

impl<'a> Shooting<'a> {
    /// Divides episodes into segments; `dof` gives the directions in which the object moves.
    ///
    /// # Errors
    /// When an episode is too short, or the parameters of `how` are invalid.
    pub fn new(episodes: &[Prepared], noise: &Noise, dof: [bool; 3], how: Cut) -> Result<Self, InferError> {
        check(how)?;
        let (mut segments, mut motion) = (vec![], vec![]);
        for (index, episode) in episodes.iter().enumerate() {
            let (own, smoothed) = of_episode(index, episode, noise, how)?;
            segments.extend(own);
            motion.extend(smoothed);
        }
        if segments.is_empty() {
            return Err(no_data("no episode is left to fit"));
        }
        let with_twist = matches!(how, Cut::Steps { .. });
        Ok(Self {
            segments,
            episodes: episodes.iter().map(|e| e.name.clone()).collect(),
            compared: compared(dof, with_twist),
            sigma: Sigma::Unknown {
                median: Scatter::from_noise(noise, motion.iter()),
                spread: LOG_SCATTER_SD,
            },
            loss: Loss::default(),
            channels: Channels::of(noise),
            stepper: None,
        })
    }

    /// Compares the states after transitions, poses and twists alike (eq. 8 on the rows of eq. 7). The state
    /// before and the wrench are assumed exact, and all directions move.
    ///
    /// # Errors
    /// When `data` is empty, or a number is not finite.
    pub fn of_transitions(data: &[Transition]) -> Result<Self, InferError> {
        if data.is_empty() {
            return Err(no_data("no transition is given"));
        }
        if let Some(index) = data.iter().position(|t| !is_finite(t)) {
            return Err(no_data(&format!("transition {index}: all numbers must be finite and dt positive")));
        }
        Ok(Self {
            segments: data.iter().map(of_transition).collect(),
            episodes: vec!["transitions".to_owned()],
            compared: compared([true; 3], true),
            sigma: Sigma::Unknown { median: Scatter::from_changes(data), spread: LOG_SCATTER_SD },
            loss: Loss::default(),
            channels: Channels { pose: [0.0; 3], reading: [0.0; 3], wander: [0.0; 3] },
            stepper: None,
        })
    }

    /// The same with another distribution of residuals.
    #[must_use]
    pub fn with_loss(self, loss: Loss) -> Self {
        Self { loss, ..self }
    }

    /// The same with known σ.
    #[must_use]
    pub fn with_scatter(self, scatter: Scatter) -> Self {
        Self { sigma: Sigma::Known(scatter), ..self }
    }

    /// The same simulated by `stepper`, with derivatives by central differences.
    #[must_use]
    pub fn simulated_by(self, stepper: &'a dyn Stepper) -> Self {
        Self { stepper: Some(stepper), ..self }
    }

    /// The same with a subset of the episodes.
    #[must_use]
    pub fn only(&self, keep: impl Fn(usize) -> bool) -> Self {
        let segments = self.segments.iter().filter(|s| keep(s.episode)).cloned().collect();
        Self { segments, ..self.clone() }
    }

    /// Number of segments.
    pub fn segments(&self) -> usize {
        self.segments.len()
    }

    /// Number of compared states.
    pub fn observations(&self) -> usize {
        self.segments.iter().map(|s| s.observed.len()).sum()
    }

    /// Kinds of scatter in use, in the order of [`Likelihood::noise`].
    fn kinds(&self) -> Vec<usize> {
        (0..4).filter(|&k| self.compared.iter().any(|&c| kind(c) == k)).collect()
    }

    /// Values of the model's slots, and σ of each channel with the index of its slot.
    fn split_values<'v>(&self, model: &Model, values: &'v [f64]) -> Result<(&'v [f64], Sigmas), InferError> {
        let (kinds, own) = (self.kinds(), model.slots().len());
        if values.len() != own + kinds.len() {
            let (got, expected) = (values.len(), own + kinds.len());
            return Err(trundle_model::ModelError::Length { what: "parameters", got, expected }.into());
        }
        let slot = |channel| own + kinds.iter().position(|&k| k == kind(channel)).unwrap_or(0);
        Ok((&values[..own], std::array::from_fn(|c| (values[slot(c)], slot(c)))))
    }

    fn simulation<'m>(
        &'m self,
        model: &'m Model,
        values: &[f64],
        free: &[usize],
    ) -> Result<Box<dyn Simulate + Sync + 'm>, InferError> {
        Ok(match self.stepper {
            Some(stepper) => Box::new(StepperSimulation::new(stepper, model, values, free)?),
            None => Box::new(LawSimulation::new(model, values, free)?),
        })
    }

    /// A simulation error with its episode and time.
    fn located(&self, segment: &Segment, error: StepError) -> InferError {
        let passed: f64 = segment.inputs.iter().take(error.step).map(|i| i.dt).sum();
        InferError::Step {
            episode: self.episodes.get(segment.episode).cloned().unwrap_or_default(),
            t: segment.t + passed,
            reason: error.reason,
        }
    }

    fn cost_of(
        &self,
        segment: &Segment,
        simulation: &dyn Simulate,
        sigma: &Sigmas,
    ) -> Result<f64, InferError> {
        let states = simulation.states(segment).map_err(|e| self.located(segment, e))?;
        let mut cost = 0.0;
        for (observed, state) in segment.observed.iter().zip(&states) {
            for &c in &self.compared {
                let (sd, _) = sigma[c];
                let whitened = difference(&observed.state, state, c) / sd;
                cost += self.loss.contribution(whitened * whitened, 1.0).cost + sd.ln();
            }
        }
        Ok(if cost.is_finite() { cost } else { f64::INFINITY })
    }

    /// Contribution of one segment; `own` holds the indices of the model's slots among the free ones.
    fn linearise_one(
        &self,
        segment: &Segment,
        simulation: &dyn Simulate,
        sigma: &Sigmas,
        free: &[usize],
        own: &[usize],
    ) -> Result<Linearised, InferError> {
        let failed = |e| self.located(segment, e);
        let states = simulation.states(segment).map_err(failed)?;
        let slopes = simulation.slopes(segment).map_err(failed)?;
        let mut sum = Linearised::sum(free.len(), []);
        for (i, (observed, state)) in segment.observed.iter().zip(&states).enumerate() {
            for &c in &self.compared {
                let ((sd, slot), error) = (sigma[c], difference(&observed.state, state, c));
                let row = slopes.row(6 * i + c).into_owned() / -sd;
                self.add(&mut sum, error / sd, &row, own);
                if let Some(k) = free.iter().position(|&f| f == slot) {
                    self.add_scale(&mut sum, k, error / sd, sd);
                }
                sum.cost += sd.ln();
            }
        }
        Ok(sum)
    }

    /// Adds a whitened residual with its derivatives.
    fn add(&self, sum: &mut Linearised, whitened: f64, slopes: &RowDVector<f64>, own: &[usize]) {
        let contribution = self.loss.contribution(whitened * whitened, 1.0);
        sum.cost += contribution.cost;
        for (&i, a) in own.iter().zip(slopes.iter()) {
            sum.gradient[i] += contribution.weight * whitened * a;
            for (&j, b) in own.iter().zip(slopes.iter()) {
                sum.curvature[(i, j)] += contribution.curvature * a * b;
            }
        }
    }

    /// Adds the derivatives of a whitened residual by its own σ, the free parameter `k`.
    fn add_scale(&self, sum: &mut Linearised, k: usize, whitened: f64, sd: f64) {
        let square = whitened * whitened;
        sum.gradient[k] += (1.0 - self.loss.contribution(square, 1.0).weight * square) / sd;
        sum.curvature[(k, k)] += self.loss.scale_information() / (sd * sd);
    }
}

impl Likelihood for Shooting<'_> {
    fn cost(&self, model: &Model, values: &[f64]) -> Result<f64, InferError> {
        let (own, sigma) = self.split_values(model, values)?;
        let simulation = self.simulation(model, own, &[])?;
        let of = |s: &Segment| self.cost_of(s, &*simulation, &sigma);
        let parts = self.segments.par_iter().map(of).collect::<Result<Vec<_>, InferError>>()?;
        Ok(parts.iter().sum())
    }

    fn linearise(&self, model: &Model, values: &[f64], free: &[usize]) -> Result<Linearised, InferError> {
        let (own, sigma) = self.split_values(model, values)?;
        let own_slots: Vec<usize> = (0..free.len()).filter(|&k| free[k] < own.len()).collect();
        let slots: Vec<usize> = own_slots.iter().map(|&k| free[k]).collect();
        let simulation = self.simulation(model, own, &slots)?;
        let of = |batch: &[Segment]| {
            let one = |s| self.linearise_one(s, &*simulation, &sigma, free, &own_slots);
            let parts = batch.iter().map(one).collect::<Result<Vec<_>, InferError>>()?;
            Ok(Linearised::sum(free.len(), parts))
        };
        let batch = if self.segments.len() > 16 * SEGMENTS_PER_BATCH { SEGMENTS_PER_BATCH } else { 1 };
        let parts = self.segments.par_chunks(batch).map(of).collect::<Result<Vec<_>, InferError>>()?;
        let sum = Linearised::sum(free.len(), parts);
        Ok(if sum.cost.is_nan() { Linearised { cost: f64::INFINITY, ..sum } } else { sum })
    }

    fn channels(&self) -> Channels {
        self.channels
    }

    fn noise(&self) -> Vec<Slot> {
        scatter::slots(self.sigma, &self.kinds())
    }

    fn split(&self) -> Vec<(String, Box<dyn Likelihood + '_>)> {
        let one = |(k, name): (usize, &String)| {
            let alone: Box<dyn Likelihood + '_> = Box::new(self.only(|episode| episode == k));
            (name.clone(), alone)
        };
        self.episodes.iter().enumerate().map(one).collect()
    }

    /// σ is estimated together with the parameters.
    fn tuned(&self, _: &Model, _: &[f64]) -> Result<Option<Box<dyn Likelihood + '_>>, InferError> {
        Ok(None)
    }
}

fn compared(dof: [bool; 3], with_twist: bool) -> Vec<usize> {
    (0..if with_twist { 6 } else { 3 }).filter(|c| dof[c % 3]).collect()
}

fn check(how: Cut) -> Result<(), InferError> {
    match how {
        Cut::Steps { stride: 0 } => Err(no_data("steps of 0 pose samples: stride must be at least 1")),
        Cut::Windows { length } if !(length.is_finite() && length > 0.0) => {
            Err(no_data(&format!("a window of {length} s: length must be positive")))
        }
        _ => Ok(()),
    }
}

fn no_data(reason: &str) -> InferError {
    InferError::NoData {
        recording: "the fit".to_owned(),
        reason: reason.to_owned(),
        remedy: "change the settings or give more data".to_owned(),
    }
}

fn is_finite(t: &Transition) -> bool {
    let all = |numbers: &[f64]| numbers.iter().all(|v| v.is_finite());
    all(&t.before) && all(&t.wrench) && all(&t.after) && t.dt.is_finite() && t.dt > 0.0
}

#[cfg(test)]
mod tests;
