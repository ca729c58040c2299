//! Regression of a rigid body on viscous wheels, perhaps with dry friction, from observed poses and twists and the applied wrench.
//!
//! In object axes about the object's origin, with the twist `ν = (u, v, ω)`:
//!
//! ```text
//! d/dt p + (−ω p_y, ω p_x, u p_y − v p_x) + D ν = wrench,   p = (m (u − ω c_y), m (v + ω c_x), I ω + m (c_x v − c_y u))
//! ```
//!
//! It is linear in the mass `m`, the first moments `m c`, the inertia `I` about the origin, and the symmetric damping
//! matrix `D`, which is the sum of all viscous wheels (Atkeson, An, Hollerbach, "Estimation of inertial parameters of
//! manipulator loads and links", 1986). The posterior therefore has one mode, and no search is necessary.
//!
//! The sliding friction `F` of the whole body enters linearly too, with the direction of the observed twist. It is part of
//! the model if the evidence for it is strong. An object at rest that does not yield to a wrench shows a friction of at
//! least that wrench.
//!
//! The equation is integrated over each step of constant wrench. The noise of an observed twist enters the two steps before
//! and after it with opposite signs. The errors of the wrench and of the model are independent; their density is estimated
//! by maximum likelihood. Steps with a large error, such as those in contact with an obstacle, have less weight (Student's
//! t). If most of the latest steps have large errors, the friction has changed: earlier steps are dropped, and what they
//! show about the mass becomes the prior.

mod dry_friction;
mod equation;
mod feasible;
mod parameters;
mod prior;
mod whitening;

use nalgebra::{SMatrix, SVector};
use trundle_model::{Body, Model, Posterior};

use crate::baseline::{BaselineError, Transition, check};
use dry_friction::Contact;
use equation::{StepEquation, mass_matrix};
use parameters::{DRY_FRICTION, MIN_MASS_RATIO, Parameters, Precision};
use prior::BodyPrior;
use whitening::{Whitened, whiten};

/// Degrees of freedom of Student's t distribution of the error of a step.
const STUDENT_DEGREES: f64 = 4.0;
/// Initial density of the noise of wrench and model, N²·s.
const INITIAL_NOISE_DENSITY: f64 = 3.0;
/// Range of that density.
const NOISE_DENSITIES: (f64, f64) = (1e-3, 1e5);
/// Factor between the densities that an update compares.
const DENSITY_RATIO: f64 = 3.0;
/// Number of passes of an update: weights, mass and scale of the prior follow from the previous one.
const PASSES: usize = 2;

/// Prior odds of dry friction: the evidence for it must be strong (Jeffreys 1961).
const DRY_PRIOR_ODDS: f64 = 0.1;

/// Number of steps that show a change.
const CHANGE_STEPS: usize = 6;
/// Smallest number of them with large errors, and largest weight of such a step. Normal errors give it to one step in 4000 (χ² of
/// three degrees of freedom above 19.3).
const MIN_CHANGED_STEPS: usize = 5;
const MAX_CHANGED_WEIGHT: f64 = 0.3;

/// Standard deviations of the noise of observed twists and wrenches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepNoise {
    /// Velocity and spin, `[m/s, m/s, rad/s]`.
    pub twist: [f64; 3],
    /// Mean wrench of a step, `[N, N, N·m]`.
    pub wrench: [f64; 3],
}

/// Estimate of a body and its damping. All data are used again at each update.
#[derive(Clone, Debug)]
pub struct BodyRegression {
    body: Body,
    prior: BodyPrior,
    noise: StepNoise,
    /// Density of the noise of wrench and model, N²·s.
    density: f64,
    /// Weight of each step.
    weights: Vec<f64>,
    /// First step that is used.
    first: usize,
    mean: Parameters,
    precision: Precision,
    /// Whether the evidence is larger with dry friction.
    is_dry: bool,
    /// Dry friction if there is any, N.
    friction: f64,
    /// Force that the object withstands at rest, N.
    withstood: f64,
}

impl BodyRegression {
    /// Start from the prior. `body` has the outline and the most probable mass.
    pub fn new(body: Body, noise: StepNoise) -> Self {
        let prior = BodyPrior::of(&body);
        let (mean, precision) = prior.at(body.mass, false);
        Self {
            body,
            prior,
            noise,
            density: INITIAL_NOISE_DENSITY,
            weights: vec![],
            first: 0,
            mean,
            precision,
            is_dry: false,
            friction: 0.0,
            withstood: 0.0,
        }
    }

    /// Estimate from all transitions of an episode so far, in order of time, each of which starts where the previous
    /// one ends.
    ///
    /// # Errors
    /// If there is no transition, or a number is not finite.
    pub fn update(&mut self, data: &[Transition]) -> Result<(), BaselineError> {
        check(data)?;
        let data = data.get(self.first..).unwrap_or_default();
        self.estimate(data);
        if let Some(change) = self.change() {
            self.prior.learn_mass(&self.mean, &self.precision);
            self.first += change;
            self.weights = vec![];
            self.estimate(&data[change..]);
        }
        Ok(())
    }

    /// The first of the latest steps with a large error, if most of them have large errors.
    fn change(&self) -> Option<usize> {
        let earlier =
            self.weights.len().checked_sub(CHANGE_STEPS).filter(|earlier| *earlier >= CHANGE_STEPS)?;
        let changed = (earlier..self.weights.len()).filter(|k| self.weights[*k] < MAX_CHANGED_WEIGHT);
        let first = changed.clone().next()?;
        (changed.count() >= MIN_CHANGED_STEPS).then_some(first)
    }

    fn estimate(&mut self, data: &[Transition]) {
        self.weights.resize(data.len(), 1.0);
        let dt = data.first().map_or(0.0, |step| step.dt);
        for pass in 0..PASSES {
            let contact = self.contact();
            self.withstood = contact.withstood(data, self.noise.twist, self.mass());
            let mean_twist = feasible::mean_twist(&self.body, &self.prior, &self.mean, dt);
            let equations: Vec<_> =
                data.iter().map(|step| StepEquation::of(step, &mean_twist, &contact)).collect();
            let densities = match pass + 1 == PASSES {
                true => [1.0, 1.0 / DENSITY_RATIO, DENSITY_RATIO].map(|ratio| ratio * self.density).to_vec(),
                false => vec![self.density],
            };
            let best = |is_dry: bool| {
                let within = |q: &f64| q.clamp(NOISE_DENSITIES.0, NOISE_DENSITIES.1);
                let solved =
                    densities.iter().filter_map(|density| self.solve(&equations, within(density), is_dry));
                solved.min_by(|a, b| a.cost.total_cmp(&b.cost))
            };
            let (rolling, sliding) = (best(false), best(true));
            let friction = sliding.as_ref().map_or(0.0, |found| found.mean[DRY_FRICTION].max(0.0));
            let sliding = sliding.filter(|_| friction > 0.0);
            let Some(best) = rolling.into_iter().chain(sliding).min_by(|a, b| a.cost.total_cmp(&b.cost))
            else {
                break;
            };
            self.friction = friction;
            (self.mean, self.precision, self.density, self.is_dry) =
                (best.mean, best.precision, best.density, best.is_dry);
            self.reweight(&equations);
        }
    }

    /// Where the floor resists.
    fn contact(&self) -> Contact {
        let [low, high] = self.body.bounds();
        let center = [0, 1].map(|k| (self.mean[k + 1] / self.mass()).clamp(low[k], high[k]));
        Contact::new(center, self.prior.half, self.noise.twist)
    }

    /// Posterior with a density of the noise, with or without dry friction; `None` if it is not finite.
    fn solve(&self, equations: &[StepEquation], density: f64, is_dry: bool) -> Option<Solution> {
        let (twist, other) = self.covariances(equations, density);
        let weights = self.weights_with(equations, &other, is_dry);
        let Whitened { precision, information, square, log_determinant } =
            whiten(equations, &weights, &twist, &other)?;
        let (prior_mean, prior_precision) = self.prior.at(self.mass(), is_dry);
        let pull = prior_precision * prior_mean;
        let total = precision + prior_precision;
        let factor = total.cholesky()?;
        let mean = factor.solve(&(information + pull));
        // Sum of squares of all errors, those from the prior included.
        let squares = square + prior_mean.dot(&pull) - mean.dot(&(information + pull));
        let volume: f64 = factor.l_dirty().diagonal().iter().map(|d| d.ln()).sum();
        let prior_volume = 0.5 * prior_precision[(DRY_FRICTION, DRY_FRICTION)].ln();
        let odds = if is_dry { DRY_PRIOR_ODDS } else { 1.0 };
        let cost = 0.5 * squares + log_determinant + volume - prior_volume - odds.ln();
        cost.is_finite().then_some(Solution { mean, precision: total, density, is_dry, cost })
    }

    /// Weights that include the unknown direction of dry friction.
    fn weights_with(&self, equations: &[StepEquation], other: &[f64; 3], is_dry: bool) -> Vec<f64> {
        let friction = if is_dry { self.friction.max(self.withstood) } else { 0.0 };
        let one = |(weight, equation): (&f64, &StepEquation)| {
            let impulse = friction * equation.dt;
            let hidden = 0.5 * equation.undirected * impulse * impulse;
            1.0 / (1.0 / weight + hidden / other[0])
        };
        self.weights.iter().zip(equations).map(one).collect()
    }

    /// Covariance of the momentum due to the noise of a twist, and of all other errors of a step.
    fn covariances(&self, equations: &[StepEquation], density: f64) -> ([f64; 9], [f64; 3]) {
        let mass = mass_matrix([0, 1, 2, 3].map(|k| self.mean[k]));
        let spread = SMatrix::<f64, 3, 3>::from_diagonal(&SVector::from(self.noise.twist.map(|sd| sd * sd)));
        let twist = mass * spread * mass.transpose();
        let dt = equations.first().map_or(0.0, |equation| equation.dt);
        let arm = self.prior.gyration * self.prior.gyration;
        let [fx, fy, torque] = self.noise.wrench.map(|sd| (sd * dt) * (sd * dt));
        let random = density * dt;
        (twist.as_slice().try_into().unwrap_or([0.0; 9]), [fx + random, fy + random, torque + random * arm])
    }

    /// Weights of the steps from their errors.
    fn reweight(&mut self, equations: &[StepEquation]) {
        let (twist, other) = self.covariances(equations, self.density);
        let twist = SMatrix::<f64, 3, 3>::from_column_slice(&twist) * 2.0;
        let other_matrix = SMatrix::<f64, 3, 3>::from_diagonal(&SVector::from(other));
        self.weights.fill(1.0);
        let known = self.weights_with(equations, &other, self.is_dry);
        for ((weight, equation), known) in self.weights.iter_mut().zip(equations).zip(known) {
            let Some(factor) = (twist + other_matrix / known).cholesky() else { continue };
            let error = equation.impulse - equation.regressors * self.mean;
            let squares = error.dot(&factor.solve(&error));
            *weight = ((STUDENT_DEGREES + 3.0) / (STUDENT_DEGREES + squares)).min(1.0);
        }
    }

    fn mass(&self) -> f64 {
        self.mean[0].max(MIN_MASS_RATIO * self.body.mass)
    }

    /// The most probable model: the body, a viscous wheel, a damping of the spin, and dry friction if there is any.
    pub fn model(&self) -> Model {
        let mut model = feasible::model(&self.body, &self.prior, &self.mean);
        let sliding = if self.is_dry { self.friction } else { 0.0 };
        let friction = sliding.max(self.withstood);
        if friction > 0.0 {
            self.contact().add_to(&mut model, friction);
        }
        model
    }

    /// Approximate posterior of the parameters of [`Self::model`] that are identified.
    pub fn posterior(&self) -> Option<Posterior> {
        feasible::posterior(&self.body, &self.prior, &self.mean, &self.precision)
    }
}

/// Posterior with one density of the noise.
struct Solution {
    mean: Parameters,
    precision: Precision,
    density: f64,
    is_dry: bool,
    /// −log of the marginal likelihood, up to a constant.
    cost: f64,
}

#[cfg(test)]
mod tests;
