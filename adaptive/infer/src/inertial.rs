//! Likelihood of the wrench that a motion requires, inertia included (inverse dynamics; eq. 4 solved for the
//! wrench).
//!
//! ```text
//! r = M a − laws(x) − recorded,   cov r = M A Mᵀ + D V Dᵀ + diag(σ_f², σ_f², σ_τ²)
//! ```
//! `A` and `V` are the smoother's covariances of acceleration and twist, `M` is the mass matrix about the
//! object origin, and `D` is the damping matrix of the laws. The estimated σ covers the error of readings and
//! laws. The method runs no simulation, so it has neither an initial state nor drift. It cannot recover
//! motion that the smoother removes, and near a locked wheel the twist is too uncertain.

use crate::curve::Curve;
use crate::likelihood::{Likelihood, Linearised};
use crate::steady_segments::is_moving;
use crate::timing::Timing;
use crate::{Channels, InferError, Loss};
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;
use std::sync::Arc;
use trundle_model::{
    Clock, Dual, Model, ModelError, Plant, Prior, Real, Rigid, Slot, State, to_body, transport,
};
use trundle_record::{Motion, Noise, Prepared};

/// Maximum number of parameters differentiated together.
const MAX_DUALS: usize = 8;

/// Interval between samples, s: about the averaging time of the smoother, so that the errors are independent.
const SAMPLE_SPACING_S: f64 = 0.1;

/// Minimum number of samples.
const MIN_SAMPLES: usize = 3;

/// Prior standard deviation of the logarithm of an unknown scatter.
const LOG_SCATTER_SD: f64 = 1.0;

/// Motion at one time, object axes, and the wrench reading around it.
#[derive(Clone, Debug)]
struct Sample {
    episode: usize,
    state: State<f64>,
    clock: Clock,
    /// Acceleration of the origin, object axes.
    accel: [f64; 3],
    /// Covariances of acceleration and twist, object axes.
    covariance: [Matrix3<f64>; 2],
    /// Mean reading, reading axes, and the pose of the reading frame in the object frame.
    reading: [f64; 3],
    frame: [f64; 3],
    /// All readings of the episode.
    curve: Arc<Curve>,
}

/// Compares the wrench that a recorded motion requires with the recorded wrench, at poses where the object
/// moves.
#[derive(Clone)]
pub struct InertialLikelihood {
    samples: Vec<Sample>,
    episodes: Vec<String>,
    dof: [bool; 3],
    /// Prior medians of the scatter: N, N·m.
    median: [f64; 2],
    loss: Loss,
    channels: Channels,
}

impl InertialLikelihood {
    /// Likelihood of the given episodes.
    ///
    /// # Errors
    /// When fewer than three samples of motion under a wrench are found.
    pub fn new(episodes: &[Prepared], noise: &Noise, dof: [bool; 3]) -> Result<Self, InferError> {
        let of = |(index, episode): (usize, &Prepared)| samples(index, episode, noise);
        let samples: Vec<Sample> = episodes.iter().enumerate().flat_map(of).collect();
        if samples.len() < MIN_SAMPLES {
            return Err(InferError::NoData {
                recording: "the fit".to_owned(),
                reason: format!(
                    "only {} samples of motion under a wrench are left; at least {MIN_SAMPLES} are required",
                    samples.len()
                ),
                remedy: "record pushes that move the object further than the tracker's noise".to_owned(),
            });
        }
        Ok(Self {
            samples,
            episodes: episodes.iter().map(|e| e.name.clone()).collect(),
            dof,
            median: [noise.force.max(1e-9), noise.torque.max(1e-9)],
            loss: Loss::default(),
            channels: Channels::of(noise),
        })
    }

    /// The same likelihood with another distribution of residuals.
    #[must_use]
    pub fn with_loss(self, loss: Loss) -> Self {
        Self { loss, ..self }
    }

    /// The same likelihood over a subset of the episodes.
    #[must_use]
    pub fn only(&self, keep: impl Fn(usize) -> bool) -> Self {
        Self { samples: self.samples.iter().filter(|s| keep(s.episode)).cloned().collect(), ..self.clone() }
    }

    /// Number of compared samples.
    pub fn observations(&self) -> usize {
        self.samples.len()
    }

    fn directions(&self) -> f64 {
        self.dof.iter().filter(|&&moves| moves).count() as f64
    }

    /// Residual and covariance of a sample. Blocked directions have no effect.
    fn compare<T: Real>(&self, s: &Sample, plant: &Plant<T>, scatter: [T; 2]) -> ([T; 3], [[T; 3]; 3]) {
        let state = State::moving(s.state.pose.map(T::lift), s.state.twist.map(T::lift));
        let force = plant.generalised_force(&state, s.clock);
        let spin = s.state.twist[2];
        let laws = force.wrench(to_body(state.twist, state.pose[2]));
        let reading = match Timing::of(plant, s.clock) {
            None => s.reading.map(T::lift),
            Some(timing) => {
                timing.mean(&s.curve, s.clock.t - 0.5 * SAMPLE_SPACING_S, s.clock.t + 0.5 * SAMPLE_SPACING_S)
            }
        };
        let read = transport(plant.correct(reading, s.clock), s.frame);
        let rigid = plant.rigid(s.clock);
        let mass = inertia(&rigid);
        let [x, y] = [0, 1].map(|k| rigid.mass * rigid.com[k] * (-spin * spin));
        let turning = [x, y, T::zero()];
        let residual = [0, 1, 2].map(|i| {
            let inert = (0..3).fold(turning[i], |sum, j| sum + mass[i][j] * s.accel[j]);
            if self.dof[i] { inert - laws[i] - read[i] } else { T::zero() }
        });
        let [xx, xy, yy, xt, yt, tt] = force.damping;
        let drag = [[xx, xy, xt], [xy, yy, yt], [xt, yt, tt]];
        let mut covariance = congruence(&mass, &s.covariance[0]);
        let twist = congruence(&drag, &s.covariance[1]);
        for i in 0..3 {
            for j in 0..3 {
                let both = self.dof[i] && self.dof[j];
                covariance[i][j] = if both { covariance[i][j] + twist[i][j] } else { T::zero() };
            }
            covariance[i][i] +=
                if self.dof[i] { scatter[usize::from(i == 2)].squared() } else { T::lift(1.0) };
        }
        (residual, covariance)
    }

    fn split_values<'v>(
        &self,
        model: &Model,
        values: &'v [f64],
    ) -> Result<(&'v [f64], [f64; 2]), InferError> {
        let own = model.slots().len();
        let (got, expected) = (values.len(), own + self.noise().len());
        if got != expected {
            return Err(ModelError::Length { what: "parameters", got, expected }.into());
        }
        Ok((&values[..own], [values[own], values.get(own + 1).copied().unwrap_or(1.0)]))
    }

    fn cost_of(&self, residual: &Vector3<f64>, covariance: &Matrix3<f64>) -> f64 {
        let Some(factor) = covariance.cholesky() else { return f64::INFINITY };
        let whitened =
            factor.l().solve_lower_triangular(residual).unwrap_or_else(|| Vector3::repeat(f64::NAN));
        let size: f64 = factor.l().diagonal().iter().map(|d| d.ln()).sum();
        let cost = self.loss.contribution(whitened.norm_squared(), self.directions()).cost + size;
        if cost.is_finite() { cost } else { f64::INFINITY }
    }

    /// Contribution of one sample, with derivatives by up to [`MAX_DUALS`] columns at a time.
    fn linearise_one(&self, sample: &Sample, groups: &[Group], n: usize) -> Linearised {
        let mut sum = Linearised::sum(n, []);
        let mut columns: Vec<(Vector3<f64>, Matrix3<f64>)> = Vec::with_capacity(n);
        let mut value = None;
        for group in groups {
            let (r, s) = self.compare(sample, &group.plant, group.scatter);
            value = Some((Vector3::from(r.map(Real::re)), Matrix3::from_fn(|i, j| s[i][j].re)));
            columns.extend(
                (0..group.columns)
                    .map(|k| (Vector3::from(r.map(|r| r.eps[k])), Matrix3::from_fn(|i, j| s[i][j].eps[k]))),
            );
        }
        let Some((residual, covariance)) = value else { return sum };
        sum.cost = self.cost_of(&residual, &covariance);
        let Some(inverse) = covariance.cholesky().and_then(|c| c.l().try_inverse()) else { return sum };
        let whitened = inverse * residual;
        let contribution = self.loss.contribution(whitened.norm_squared(), self.directions());
        let columns: Vec<_> =
            columns.iter().map(|(r, s)| (inverse * r, inverse * s * inverse.transpose())).collect();
        for (i, (r, s)) in columns.iter().enumerate() {
            let square = whitened.dot(r) - 0.5 * whitened.dot(&(s * whitened));
            sum.gradient[i] = contribution.weight * square + 0.5 * s.trace();
            for (j, (other, t)) in columns.iter().enumerate() {
                // Fisher information of the mean and the covariance of a normal vector.
                let scale = contribution.curvature / contribution.weight;
                sum.curvature[(i, j)] = contribution.curvature * r.dot(other) + 0.5 * scale * (s * t).trace();
            }
        }
        sum
    }
}

/// A plant with some of the free parameters as dual variables.
struct Group {
    plant: Plant<Dual<MAX_DUALS>>,
    scatter: [Dual<MAX_DUALS>; 2],
    columns: usize,
}

fn group(model: &Model, values: &[f64], scatter: [f64; 2], free: &[usize]) -> Result<Group, InferError> {
    let all: Vec<f64> = values.iter().copied().chain(scatter).collect();
    let mut lifted: Vec<Dual<MAX_DUALS>> = all.iter().map(|&v| Real::lift(v)).collect();
    for (k, &slot) in free.iter().enumerate() {
        lifted[slot] = Dual::variable(all[slot], k);
    }
    let own = values.len();
    let scatter = [lifted[own], lifted[own + 1]];
    Ok(Group { plant: model.plant(&lifted[..own])?, scatter, columns: free.len() })
}

/// Mass matrix about the object origin, object axes.
fn inertia<T: Real>(rigid: &Rigid<T>) -> [[T; 3]; 3] {
    let ([x, y], m, zero) = (rigid.com, rigid.mass, T::zero());
    let polar = rigid.inertia + m * (x.squared() + y.squared());
    [[m, zero, -(m * y)], [zero, m, m * x], [-(m * y), m * x, polar]]
}

/// `A C Aᵀ` for a symmetric `A`.
fn congruence<T: Real>(a: &[[T; 3]; 3], c: &Matrix3<f64>) -> [[T; 3]; 3] {
    let left =
        [0, 1, 2].map(|i| [0, 1, 2].map(|j| (0..3).fold(T::zero(), |sum, k| sum + a[i][k] * c[(k, j)])));
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| (0..3).fold(T::zero(), |sum, k| sum + left[i][k] * a[k][j])))
}

impl Likelihood for InertialLikelihood {
    fn cost(&self, model: &Model, values: &[f64]) -> Result<f64, InferError> {
        let (own, scatter) = self.split_values(model, values)?;
        let plant = model.plant(own)?;
        let one = |s: &Sample| {
            let (residual, covariance) = self.compare(s, &plant, scatter);
            self.cost_of(&Vector3::from(residual), &Matrix3::from_fn(|i, j| covariance[i][j]))
        };
        Ok(self.samples.iter().map(one).sum())
    }

    fn linearise(&self, model: &Model, values: &[f64], free: &[usize]) -> Result<Linearised, InferError> {
        let (own, scatter) = self.split_values(model, values)?;
        let mut groups =
            free.chunks(MAX_DUALS).map(|f| group(model, own, scatter, f)).collect::<Result<Vec<_>, _>>()?;
        if groups.is_empty() {
            groups.push(group(model, own, scatter, &[])?);
        }
        let one = |s: &Sample| self.linearise_one(s, &groups, free.len());
        let parts: Vec<_> = self.samples.par_iter().map(one).collect();
        Ok(Linearised::sum(free.len(), parts))
    }

    fn channels(&self) -> Channels {
        self.channels
    }

    fn noise(&self) -> Vec<Slot> {
        let one = |(name, unit, median): (&str, &'static str, f64)| Slot {
            name: name.to_owned(),
            unit,
            lower: 1e-12,
            upper: 1e6,
            prior: Prior::LogNormal { median, sd: LOG_SCATTER_SD },
            value: None,
            effect: None,
        };
        let [force, torque] = self.median;
        let kinds = [("noise.force", "N", force), ("noise.torque", "N·m", torque)];
        kinds.into_iter().take(if self.dof[2] { 2 } else { 1 }).map(one).collect()
    }

    fn split(&self) -> Vec<(String, Box<dyn Likelihood + '_>)> {
        let one = |(k, name): (usize, &String)| {
            let alone: Box<dyn Likelihood> = Box::new(self.only(|episode| episode == k));
            (name.clone(), alone)
        };
        self.episodes.iter().enumerate().map(one).collect()
    }

    /// σ is estimated together with the parameters.
    fn tuned(&self, _: &Model, _: &[f64]) -> Result<Option<Box<dyn Likelihood + '_>>, InferError> {
        Ok(None)
    }
}

/// Samples of an episode: poses at which the object moves, at least [`SAMPLE_SPACING_S`] apart.
fn samples(index: usize, episode: &Prepared, noise: &Noise) -> Vec<Sample> {
    let mut found: Vec<Sample> = vec![];
    let mut next = episode.contact + 0.5 * SAMPLE_SPACING_S;
    let curve = Arc::new(Curve::new(episode));
    for motion in episode.motion(noise).iter().filter(|m| is_moving(m)) {
        if motion.t < next {
            continue;
        }
        if let Some(sample) = sample(index, episode, &curve, motion) {
            found.push(sample);
            next = motion.t + SAMPLE_SPACING_S;
        }
    }
    found
}

fn sample(index: usize, episode: &Prepared, curve: &Arc<Curve>, motion: &Motion) -> Option<Sample> {
    let first = episode.wrench.partition_point(|w| w.t < motion.t - 0.5 * SAMPLE_SPACING_S);
    let end = episode.wrench.partition_point(|w| w.t <= motion.t + 0.5 * SAMPLE_SPACING_S);
    let near = episode.wrench.get(first..end).filter(|near| !near.is_empty())?;
    let frame = curve.frame(motion.t).0;
    let mean = |k: usize| near.iter().map(|w| w.reading[k]).sum::<f64>() / near.len() as f64;
    let turn = |order: usize| {
        let (sin, cos) = motion.pose[2].sin_cos();
        let turn = Matrix3::new(cos, sin, 0.0, -sin, cos, 0.0, 0.0, 0.0, 1.0);
        let world = Matrix3::from_diagonal(&Vector3::from_fn(|k, _| motion.cov[k][order][order]));
        turn * world * turn.transpose()
    };
    Some(Sample {
        episode: index,
        state: State::moving(motion.pose, motion.twist),
        clock: curve.clock_at_grasp(motion.t, frame),
        accel: to_body(motion.accel, motion.pose[2]),
        covariance: [turn(2), turn(1)],
        reading: [0, 1, 2].map(mean),
        frame,
        curve: curve.clone(),
    })
}

#[cfg(test)]
mod tests;
