//! An extended Kalman filter over an episode: the exact likelihood of poses under wrench noise, up
//! to linearisation.
//!
//! The state is pose, twist and the error of the wrench reading. That error starts as the
//! tare's and may wander: its smoothed course is the wrench that the model misses.

#[path = "response.rs"]
mod response;

use crate::curve::Curve;
use crate::{Channels, InferError, Track, track::Step};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use trundle_model::{Clock, Dual, INNER, Inner, Model, Plant, Real, State, transport};

pub use response::Response;

/// Pose, twist and wrench error.
const PLAIN: usize = 9;
/// The same, and the laws' own states.
pub(crate) const STATES: usize = PLAIN + INNER;
/// Pose and twist.
const MOTION: usize = 6;
type Matrix<const N: usize> = SMatrix<f64, N, N>;
type Vector<const N: usize> = SVector<f64, N>;

/// Beginning of an episode by which the laws' own starting states are chosen, s.
const BEGINNING: f64 = 1.0;

/// What one pose sample said.
#[derive(Clone, Debug)]
pub struct Innovation {
    /// Time, s.
    pub t: f64,
    /// Seen less predicted pose.
    pub error: Vector3<f64>,
    /// Its covariance.
    pub covariance: Matrix3<f64>,
    /// Filter gain: what the sample moves in the state.
    pub gain: SMatrix<f64, STATES, 3>,
    /// Inverse of the Cholesky factor of the covariance; rows of blocked directions are zero.
    pub whitener: Matrix3<f64>,
    /// −log density of the sample.
    pub cost: f64,
}

/// The wrench that the model misses at one time, object axes about the object origin.
#[derive(Clone, Debug)]
pub struct Residual {
    /// Time, s.
    pub t: f64,
    /// Smoothed pose.
    pub pose: [f64; 3],
    /// Smoothed twist, world axes.
    pub twist: [f64; 3],
    /// Wrench on the object that the model does not explain, N, N, N·m.
    pub wrench: [f64; 3],
    /// Its covariance.
    pub covariance: Matrix3<f64>,
}

#[derive(Clone)]
struct Belief<const N: usize> {
    mean: Vector<N>,
    covariance: Matrix<N>,
}

/// One prediction, kept for smoothing.
struct Stage<const N: usize> {
    transition: Matrix<N>,
    predicted: Belief<N>,
    filtered: Belief<N>,
    frame: [f64; 3],
    t: f64,
}

/// What a filter found along an episode.
pub(crate) struct Passage {
    /// Of every pose sample, in order.
    pub innovations: Vec<Innovation>,
    /// The laws' own states that it started from.
    pub inner: [f64; INNER],
}

/// Filters episodes with one plant. `None` where a number is not finite.
pub(crate) trait Filtering: Sync {
    /// The innovation of every pose sample.
    fn run(&self, track: &Track) -> Option<Passage>;
    /// The wrench error at every pose sample, given the whole episode (Rauch-Tung-Striebel).
    fn smooth(&self, track: &Track) -> Option<Vec<Residual>>;
    /// The density of every pose sample as predicted from the track's start alone.
    fn predict_only(&self, track: &Track) -> Option<Vec<Innovation>>;
    /// The density of the pose samples of windows of `length` seconds, each predicted from what the filter knew at its
    /// start; `None` in place of a window that is not finite.
    fn ahead(&self, track: &Track, starts: &[f64], length: f64) -> Option<Vec<Option<Vec<Innovation>>>>;
    /// The episode as a linear system about this plant.
    fn response(&self, track: &Track) -> Option<Response>;
}

/// The filter for a model at values.
pub(crate) fn filter<'a>(
    model: &Model,
    values: &[f64],
    channels: &'a Channels,
) -> Result<Box<dyn Filtering + 'a>, InferError> {
    let inner = model.inner();
    if inner.is_empty() {
        return Ok(Box::new(Filter::<PLAIN>::new(model, values, channels, inner)?));
    }
    Ok(Box::new(Filter::<STATES>::new(model, values, channels, inner)?))
}

/// Filters with `N` states.
struct Filter<'a, const N: usize> {
    plant: Plant<Dual<N>>,
    channels: &'a Channels,
    dof: [bool; 3],
    inner: Vec<Inner>,
}

impl<const N: usize> Filtering for Filter<'_, N> {
    fn run(&self, track: &Track) -> Option<Passage> {
        let inner = self.inner_start(track)?;
        let mut innovations = Vec::with_capacity(track.observations());
        self.walk(track, &inner, f64::INFINITY, |_, _, seen| innovations.extend(seen.cloned()))?;
        Some(Passage { innovations, inner })
    }

    fn smooth(&self, track: &Track) -> Option<Vec<Residual>> {
        let mut stages: Vec<Stage<N>> = Vec::with_capacity(track.steps.len());
        let inner = self.inner_start(track)?;
        let mut belief = self.begin(track, &inner);
        let mut t = track.start;
        for step in &track.steps {
            let (predicted, transition) = self.predict(&belief, step, &track.curve);
            t += step.dt;
            let filtered = match step.pose {
                Some(seen) => self.update(predicted.clone(), &self.observe(&predicted, t, seen)?),
                None => predicted.clone(),
            };
            belief = filtered.clone();
            stages.push(Stage { transition, predicted, filtered, frame: step.frame, t });
        }
        Some(backward(stages))
    }

    fn predict_only(&self, track: &Track) -> Option<Vec<Innovation>> {
        let belief = self.begin(track, &self.inner_start(track)?);
        self.onwards(&track.steps, &track.curve, belief, track.start)
    }

    fn ahead(&self, track: &Track, starts: &[f64], length: f64) -> Option<Vec<Option<Vec<Innovation>>>> {
        let mut belief = self.begin(track, &self.inner_start(track)?);
        let (mut t, mut starts, mut found) = (track.start, starts.iter().peekable(), vec![]);
        for (index, step) in track.steps.iter().enumerate() {
            while starts.next_if(|start| **start <= t + 1e-9).is_some() {
                let mut end = t;
                let within = track.steps[index..].iter().take_while(|step| {
                    end += step.dt;
                    end <= t + length + 1e-9
                });
                let count = within.count();
                found.push(self.onwards(&track.steps[index..index + count], &track.curve, belief.clone(), t));
            }
            (belief, _) = self.predict(&belief, step, &track.curve);
            t += step.dt;
            if let Some(seen) = step.pose {
                let innovation = self.observe(&belief, t, seen)?;
                belief = self.update(belief, &innovation);
            }
        }
        Some(found)
    }

    fn response(&self, track: &Track) -> Option<Response> {
        self.linear(track)
    }
}

impl<'a, const N: usize> Filter<'a, N> {
    fn new(
        model: &Model,
        values: &[f64],
        channels: &'a Channels,
        inner: Vec<Inner>,
    ) -> Result<Self, InferError> {
        let lifted: Vec<_> = values.iter().map(|&v| Real::lift(v)).collect();
        Ok(Self { plant: model.plant(&lifted)?, channels, dof: model.dof, inner })
    }

    /// Filter up to a time after the start, showing each belief before it is corrected.
    fn walk(
        &self,
        track: &Track,
        inner: &[f64; INNER],
        until: f64,
        mut show: impl FnMut(f64, &Belief<N>, Option<&Innovation>),
    ) -> Option<()> {
        let mut belief = self.begin(track, inner);
        let mut t = track.start;
        for step in &track.steps {
            (belief, _) = self.predict(&belief, step, &track.curve);
            t += step.dt;
            if t > until {
                break;
            }
            if let Some(seen) = step.pose {
                let innovation = self.observe(&belief, t, seen)?;
                show(t, &belief, Some(&innovation));
                belief = self.update(belief, &innovation);
            }
        }
        Some(())
    }

    /// Predictions of the pose samples of some steps from a belief at time `t`, correcting nothing.
    fn onwards(
        &self,
        steps: &[Step],
        curve: &Curve,
        mut belief: Belief<N>,
        mut t: f64,
    ) -> Option<Vec<Innovation>> {
        let mut predictions = vec![];
        for step in steps {
            (belief, _) = self.predict(&belief, step, curve);
            t += step.dt;
            if let Some(seen) = step.pose {
                predictions.push(self.observe(&belief, t, seen)?);
            }
        }
        Some(predictions)
    }

    /// The laws' own starting states that the episode's beginning fits best, of all that they offer.
    fn inner_start(&self, track: &Track) -> Option<[f64; INNER]> {
        let mut offers = vec![[0.0; INNER]];
        for (k, inner) in self.inner.iter().enumerate() {
            let with = |offer: &[f64; INNER], start: f64| {
                let mut offer = *offer;
                offer[k] = start;
                offer
            };
            offers = offers.iter().flat_map(|o| inner.starts.iter().map(move |&s| with(o, s))).collect();
        }
        if offers.len() < 2 {
            return offers.first().copied();
        }
        let contact = track.steps.first().map_or(0.0, |s| s.clock.t - s.clock.since_contact);
        let until = contact.max(track.start) + BEGINNING;
        let cost = |offer: &[f64; INNER]| {
            let mut cost = 0.0;
            let walked = self.walk(track, offer, until, |_, _, seen| cost += seen.map_or(0.0, |i| i.cost));
            walked.map_or(f64::INFINITY, |()| cost)
        };
        let costs: Vec<f64> = offers.iter().map(cost).collect();
        let best = (0..offers.len()).min_by(|&a, &b| costs[a].total_cmp(&costs[b]))?;
        Some(offers[best])
    }

    fn begin(&self, track: &Track, inner: &[f64; INNER]) -> Belief<N> {
        let ((pose, pose_var), (twist, twist_var)) = (track.pose, track.twist);
        let mut mean = Vector::zeros();
        let mut covariance = Matrix::zeros();
        for k in (0..3).filter(|&k| self.dof[k]) {
            (mean[k], mean[k + 3]) = (pose[k], twist[k]);
            (covariance[(k, k)], covariance[(k + 3, k + 3)]) = (pose_var[k], twist_var[k]);
            covariance[(k + 6, k + 6)] = track.tare[k];
        }
        for (k, own) in self.inner.iter().enumerate() {
            mean[PLAIN + k] = inner[k];
            covariance[(PLAIN + k, PLAIN + k)] = own.sd * own.sd;
        }
        Belief { mean, covariance }
    }

    fn predict(&self, belief: &Belief<N>, step: &Step, curve: &Curve) -> (Belief<N>, Matrix<N>) {
        let variable = |k: usize| Dual::<N>::variable(belief.mean[k], k);
        let mut state = State::moving([0, 1, 2].map(variable), [3, 4, 5].map(variable));
        for (k, own) in state.inner.iter_mut().take(N - PLAIN).enumerate() {
            *own = variable(PLAIN + k);
        }
        let error = [6, 7, 8].map(variable);
        let after = push(&self.plant, &state, error, step, curve);
        let mut transition = Matrix::identity();
        let mut mean = belief.mean;
        let rows = (0..MOTION).chain(PLAIN..N);
        for (row, value) in rows.zip(after.pose.iter().chain(&after.twist).chain(&after.inner)) {
            mean[row] = value.re;
            for column in 0..N {
                transition[(row, column)] = value.eps[column];
            }
        }
        let mut covariance = moved(&transition, &belief.covariance);
        for k in (0..3).filter(|&k| self.dof[k]) {
            let reading = self.channels.reading[k];
            let variance = reading * reading * step.thinning;
            // The reading's noise enters as its error does.
            let mut input: Vector<N> = transition.column(k + MOTION).into_owned();
            input.fixed_rows_mut::<3>(MOTION).fill(0.0);
            for column in 0..N {
                for row in 0..N {
                    covariance[(row, column)] += input[row] * (variance * input[column]);
                }
            }
            covariance[(k + 6, k + 6)] += self.channels.wander[k] * self.channels.wander[k] * step.dt;
        }
        (Belief { mean, covariance }, transition)
    }

    fn observe(&self, belief: &Belief<N>, t: f64, seen: [f64; 3]) -> Option<Innovation> {
        let mut covariance: Matrix3<f64> = belief.covariance.fixed_view::<3, 3>(0, 0).into_owned();
        let mut error = Vector3::zeros();
        for k in 0..3 {
            if self.dof[k] {
                covariance[(k, k)] += self.channels.pose[k] * self.channels.pose[k];
                error[k] = seen[k] - belief.mean[k];
            } else {
                covariance[(k, k)] = 1.0;
            }
        }
        let factor = covariance.cholesky()?;
        let mut whitener = factor.l().try_inverse()?;
        let mut gain = SMatrix::<f64, STATES, 3>::zeros();
        let own = belief.covariance.fixed_view::<N, 3>(0, 0) * factor.inverse();
        gain.fixed_view_mut::<N, 3>(0, 0).copy_from(&own);
        let whitened = whitener * error;
        let mut cost = 0.5 * whitened.norm_squared();
        for k in 0..3 {
            if self.dof[k] {
                cost += factor.l()[(k, k)].ln() + 0.5 * std::f64::consts::TAU.ln();
            } else {
                whitener.row_mut(k).fill(0.0);
            }
        }
        cost.is_finite().then_some(Innovation { t, error, covariance, gain, whitener, cost })
    }

    fn update(&self, belief: Belief<N>, innovation: &Innovation) -> Belief<N> {
        let gain = innovation.gain.fixed_view::<N, 3>(0, 0).into_owned();
        let mean = belief.mean + gain * innovation.error;
        let prior = &belief.covariance;
        // Joseph's form (I − KH) P (I − KH)ᵀ + K R Kᵀ stays positive. H takes the pose out of the state, so that
        // its products are of three columns.
        let kept = minus(prior, &gain, &prior.fixed_view::<N, 3>(0, 0).into_owned());
        let mut pose: SMatrix<f64, N, 3> = kept.fixed_view::<N, 3>(0, 0).into_owned();
        for k in 0..3 {
            let variance = self.channels.pose[k] * self.channels.pose[k];
            for row in 0..N {
                pose[(row, k)] -= gain[(row, k)] * variance;
            }
        }
        Belief { mean, covariance: symmetric(&minus(&kept, &pose, &gain)) }
    }
}

/// The mean of a matrix and its transpose: rounding makes a covariance lopsided, and over a minute that grows
/// until it is none.
fn symmetric<const N: usize>(a: &Matrix<N>) -> Matrix<N> {
    let mut even = *a;
    for column in 0..N {
        for row in 0..column {
            let mean = 0.5 * (a[(row, column)] + a[(column, row)]);
            (even[(row, column)], even[(column, row)]) = (mean, mean);
        }
    }
    even
}

/// `F P Fᵀ`, where three rows of `F` are the identity's: a reading's error stays what it is.
fn moved<const N: usize>(transition: &Matrix<N>, covariance: &Matrix<N>) -> Matrix<N> {
    let mut half = Matrix::<N>::zeros();
    for column in 0..N {
        let mut sum = [0.0; N];
        for k in 0..N {
            let by = covariance[(k, column)];
            for (row, sum) in sum.iter_mut().enumerate() {
                *sum += transition[(row, k)] * by;
            }
        }
        half.column_mut(column).copy_from_slice(&sum);
    }
    let mut product = half;
    for column in (0..MOTION).chain(PLAIN..N) {
        let mut sum = [0.0; N];
        for k in 0..N {
            let by = transition[(column, k)];
            for (row, sum) in sum.iter_mut().enumerate() {
                *sum += half[(row, k)] * by;
            }
        }
        product.column_mut(column).copy_from_slice(&sum);
    }
    product
}

/// `A − B Cᵀ`.
fn minus<const N: usize>(a: &Matrix<N>, b: &SMatrix<f64, N, 3>, c: &SMatrix<f64, N, 3>) -> Matrix<N> {
    let mut difference = *a;
    for column in 0..N {
        for k in 0..3 {
            let by = c[(column, k)];
            for row in 0..N {
                difference[(row, column)] -= b[(row, k)] * by;
            }
        }
    }
    difference
}

/// One step of a plant under a reading with an error.
#[inline]
pub(crate) fn push<T: Real>(
    plant: &Plant<T>,
    state: &State<T>,
    error: [T; 3],
    step: &Step,
    curve: &Curve,
) -> State<T> {
    let delay = plant.delay();
    let read = step.reading(curve, delay);
    let reading = [0, 1, 2].map(|k| read[k] - error[k]);
    // A late reading tells of contact late.
    let since_contact = step.clock.since_contact + delay.map_or(0.0, Real::re);
    let clock = Clock { since_contact, ..step.clock };
    let applied = transport(plant.correct(reading, clock), step.frame);
    plant.step(state, applied, clock, step.dt)
}

fn backward<const N: usize>(stages: Vec<Stage<N>>) -> Vec<Residual> {
    let mut residuals = Vec::with_capacity(stages.len());
    let mut next: Option<(Belief<N>, Belief<N>, Matrix<N>)> = None;
    for stage in stages.into_iter().rev() {
        let Stage { transition, predicted, filtered, frame, t } = stage;
        let smoothed = match next {
            None => Belief { mean: filtered.mean, covariance: filtered.covariance },
            Some((smoothed, predicted, transition)) => {
                let gain = filtered.covariance * transition.transpose() * inverse(&predicted.covariance);
                let covariance = filtered.covariance
                    + gain * (smoothed.covariance - predicted.covariance) * gain.transpose();
                Belief { mean: filtered.mean + gain * (smoothed.mean - predicted.mean), covariance }
            }
        };
        residuals.push(residual(&smoothed, frame, t));
        next = Some((smoothed, predicted, transition));
    }
    residuals.reverse();
    residuals
}

/// Inverse of a covariance whose blocked directions have no variance.
fn inverse<const N: usize>(covariance: &Matrix<N>) -> Matrix<N> {
    let mut scaled = *covariance;
    let scale = Vector::<N>::from_fn(|k, _| {
        let variance = covariance[(k, k)];
        if variance > 0.0 { variance.sqrt().recip() } else { 0.0 }
    });
    for i in 0..N {
        for j in 0..N {
            scaled[(i, j)] *= scale[i] * scale[j];
        }
        scaled[(i, i)] = if scale[i] > 0.0 { 1.0 + 1e-12 } else { 1.0 };
    }
    let inverse = scaled.cholesky().map_or_else(Matrix::zeros, |c| c.inverse());
    Matrix::from_fn(|i, j| inverse[(i, j)] * scale[i] * scale[j])
}

/// The reading's error, as the wrench on the object that the model lacks.
fn residual<const N: usize>(belief: &Belief<N>, frame: [f64; 3], t: f64) -> Residual {
    let m = &belief.mean;
    let columns = [0, 1, 2].map(|k| {
        let mut unit = [0.0; 3];
        unit[k] = -1.0;
        Vector3::from(transport(unit, frame))
    });
    let turn = Matrix3::from_columns(&columns);
    let wrench = turn * m.fixed_rows::<3>(6);
    let covariance = turn * belief.covariance.fixed_view::<3, 3>(6, 6) * turn.transpose();
    Residual { t, pose: [m[0], m[1], m[2]], twist: [m[3], m[4], m[5]], wrench: wrench.into(), covariance }
}
