//! Error metrics of a model on some episodes.

use crate::bandwidth::{force_bandwidth, spacing};
use crate::curve::Curve;
use crate::error_metrics::{ErrorMetrics, Score};
use crate::initial_state;
use crate::rollout::{Window, open_loop, windows};
use crate::steady_segments::wrench_samples;
use crate::timing::Timing;
use crate::wrench_sample::WrenchSample;
use crate::{Channels, InferError};
use rayon::prelude::*;
use trundle_model::{Clock, MAX_INNER_STATES, Model, Plant, State, to_body};
use trundle_record::{Motion, Noise, Prepared, low_pass};

/// Error metrics of a model with all values given.
///
/// # Errors
/// When `values` has the wrong length.
pub fn score(
    model: &Model,
    values: &[f64],
    channels: &Channels,
    episodes: &[Prepared],
    noise: &Noise,
    quasi_static: bool,
) -> Result<Score, InferError> {
    score_compared(model, values, channels, episodes, noise, quasi_static, None)
}

/// Error metrics of a model for a comparison with another model, given with its values. Time that is excluded
/// for one model is excluded for both ([`initial_state::unscored_time`]), and the wrenches of both are
/// compared below the same frequency.
///
/// # Errors
/// When `values` has the wrong length.
pub fn score_compared(
    model: &Model,
    values: &[f64],
    channels: &Channels,
    episodes: &[Prepared],
    noise: &Noise,
    quasi_static: bool,
    other: Option<(&Model, &[f64])>,
) -> Result<Score, InferError> {
    let plant = model.plant(values)?;
    let plant_of_other = other.map(|(model, values)| model.plant(values)).transpose()?;
    let unscored = other
        .map_or(0.0, |(other, _)| initial_state::unscored_time(other))
        .max(initial_state::unscored_time(model));
    let plants: Vec<&Plant<f64>> = std::iter::once(&plant).chain(&plant_of_other).collect();
    let bandwidth = if quasi_static { None } else { force_bandwidth(&plants, model.dof, episodes, noise) };
    let one = |episode: &Prepared| {
        let mut metrics = ErrorMetrics::default();
        if quasi_static {
            wrench_samples(episode, noise)
                .iter()
                .for_each(|sample| metrics.add_wrench(sample.residual(&plant)));
        } else {
            let rho = if model.dof[2] { model.body.gyration } else { 0.0 };
            metrics.add_open_loop(&open_loop(&plant, episode), episode, rho, unscored);
            let ahead = windows(model, values, channels, episode, noise)?;
            add_windows(&mut metrics, &ahead, episode.contact + unscored);
            for wrench in missing_wrench(&plant, episode, noise, unscored).below(bandwidth) {
                metrics.add_wrench([0, 1, 2].map(|k| if model.dof[k] { wrench[k] } else { 0.0 }));
            }
        }
        Ok(metrics)
    };
    let all = episodes.par_iter().map(one).collect::<Result<Vec<_>, InferError>>()?;
    let total = all.iter().fold(ErrorMetrics::default(), ErrorMetrics::merged).score(model.dof[2]);
    Ok(Score { force_bandwidth: bandwidth.filter(|_| total.force_rmse.is_some()), ..total })
}

/// Adds predictions of samples after the time `from`.
fn add_windows(metrics: &mut ErrorMetrics, windows: &[Option<Window>], from: f64) {
    for sample in windows.iter().flatten().flat_map(|w| &w.samples).filter(|sample| sample.t > from) {
        metrics.add_window(sample.error.into());
        metrics.add_log_density(-sample.cost);
    }
}

/// Required minus recorded wrench along an episode, object axes.
#[derive(Default)]
struct MissingWrench {
    t: Vec<f64>,
    wrench: Vec<[f64; 3]>,
}

impl MissingWrench {
    /// The wrenches without components above a frequency, Hz. The filter is linear, so filtering the
    /// difference filters both. Samples within a quarter of a period of the ends are dropped, because there
    /// the acceleration is estimated from one side only.
    fn below(mut self, bandwidth: Option<f64>) -> Vec<[f64; 3]> {
        let Some(bandwidth) = bandwidth else { return self.wrench };
        for k in 0..3 {
            let one: Vec<f64> = self.wrench.iter().map(|wrench| wrench[k]).collect();
            for (wrench, value) in self.wrench.iter_mut().zip(low_pass(&self.t, &one, bandwidth)) {
                wrench[k] = value;
            }
        }
        let (Some(first), Some(last)) = (self.t.first(), self.t.last()) else { return vec![] };
        let edge = 0.25 / bandwidth;
        let inside = |t: f64| (first + edge..=last - edge).contains(&t);
        self.t.iter().zip(self.wrench).filter(|(t, _)| inside(**t)).map(|(_, wrench)| wrench).collect()
    }
}

/// Required minus recorded wrench at every pose sample from `unscored` seconds after contact on.
fn missing_wrench(plant: &Plant<f64>, episode: &Prepared, noise: &Noise, unscored: f64) -> MissingWrench {
    let curve = Curve::new(episode);
    let near = 0.5 * spacing(std::slice::from_ref(episode)).unwrap_or(0.0);
    let mut inner_states = InnerStates::new(plant, episode, &curve);
    let mut missed = MissingWrench::default();
    for motion in episode.motion(noise).iter().filter(|m| m.t >= episode.contact) {
        let Some(sample) = sample_at(motion, (episode, &curve), plant, near) else { continue };
        let inner = inner_states.until(plant, &sample);
        if motion.t < episode.contact + unscored {
            continue;
        }
        let inertia = inertial_wrench(plant, &sample, motion.accel);
        missed.t.push(motion.t);
        missed.wrench.push(wrench_residual(plant, &sample, inner, motion, inertia));
    }
    missed
}

/// The laws' own states along the measured motion.
pub(crate) struct InnerStates {
    inner: [f64; MAX_INNER_STATES],
    last: Option<WrenchSample>,
    /// Maximum step, s.
    max_step: f64,
}

impl InnerStates {
    /// States at the start of an episode.
    pub fn new(plant: &Plant<f64>, episode: &Prepared, curve: &Curve) -> Self {
        Self { inner: initial_state::initial_state(plant, episode), last: None, max_step: curve.max_step() }
    }

    /// Advances the states from the previous sample.
    pub fn until(&mut self, plant: &Plant<f64>, sample: &WrenchSample) -> [f64; MAX_INNER_STATES] {
        if let Some(last) = self.last.as_ref().filter(|_| plant.inner() > 0) {
            let applied = last.recorded(plant);
            let count = ((sample.t - last.t) / self.max_step).ceil().max(1.0);
            let dt = (sample.t - last.t) / count;
            let mut state = State::moving(last.pose, last.twist).with_inner(self.inner);
            for k in 0..count as usize {
                let past = (k as f64 + 0.5) * dt;
                let since_contact = last.clock.since_contact + past;
                let clock = Clock { t: last.t + past, since_contact, dt, ..last.clock };
                state = plant.step(&state, applied, clock, dt);
            }
            self.inner = state.inner;
        }
        self.last = Some(sample.clone());
        self.inner
    }
}

/// Motion at a pose with the mean of the readings up to `near` seconds from it.
pub(crate) fn sample_at(
    motion: &Motion,
    (episode, curve): (&Prepared, &Curve),
    plant: &Plant<f64>,
    near: f64,
) -> Option<WrenchSample> {
    let timing = Timing::of(plant, curve.clock(motion.t));
    let at = motion.t + timing.map_or(0.0, |timing| timing.delay());
    let (first, last) = (episode.wrench.first()?.t, episode.wrench.last()?.t);
    if at < first - near || at > last + near {
        return None;
    }
    let frame = curve.frame(motion.t).0;
    Some(WrenchSample {
        episode: 0,
        t: motion.t,
        pose: motion.pose,
        twist: motion.twist,
        reading: match timing {
            Some(timing) => timing.mean(curve, motion.t - near, motion.t + near),
            None => curve.mean(at - near, at + near).reading,
        },
        frame,
        clock: curve.clock_at_grasp(motion.t, frame),
    })
}

/// Mass times acceleration of the mass centre, as a wrench about the object origin, object axes.
pub(crate) fn inertial_wrench(plant: &Plant<f64>, sample: &WrenchSample, accel: [f64; 3]) -> [f64; 3] {
    let rigid = plant.rigid(sample.clock);
    let [cx, cy] = rigid.com;
    let [ax, ay, spin_up] = to_body(accel, sample.pose[2]);
    let spin = sample.twist[2];
    let (fx, fy) = (
        rigid.mass * (ax - spin_up * cy - spin * spin * cx),
        rigid.mass * (ay + spin_up * cx - spin * spin * cy),
    );
    [fx, fy, rigid.inertia * spin_up + cx * fy - cy * fx]
}

/// Required minus recorded wrench. At rest, dry friction can supply a set of wrenches, and the twist is
/// uncertain: the smallest difference within this uncertainty counts.
fn wrench_residual(
    plant: &Plant<f64>,
    sample: &WrenchSample,
    inner: [f64; MAX_INNER_STATES],
    motion: &Motion,
    inertia: [f64; 3],
) -> [f64; 3] {
    let reach = [0, 1, 2].map(|k| 2.0 * motion.cov[k][1][1].sqrt());
    let at_rest = (0..3).all(|k| motion.twist[k].abs() <= reach[k]);
    let recorded = sample.recorded(plant);
    let missed = |twist: [f64; 3]| {
        let state = State::moving(sample.pose, twist).with_inner(inner);
        let wrench = plant.generalised_force(&state, sample.clock).wrench(to_body(twist, sample.pose[2]));
        [0, 1, 2].map(|k| inertia[k] - wrench[k] - recorded[k])
    };
    if at_rest { smallest_residual(motion.twist, reach, missed) } else { missed(motion.twist) }
}

/// Smallest difference over twists within `reach` of the start, by coordinate descent.
fn smallest_residual(start: [f64; 3], reach: [f64; 3], missed: impl Fn([f64; 3]) -> [f64; 3]) -> [f64; 3] {
    const MAX_ROUNDS: usize = 12;
    let size = |r: &[f64; 3]| r.iter().map(|x| x * x).sum::<f64>();
    let (mut twist, mut best) = (start, missed(start));
    let mut stride = 1.0;
    for _ in 0..MAX_ROUNDS {
        // Dry friction laws are monotone, so coordinate descent has no local minima.
        for k in 0..3 {
            for sign in [-1.0, 1.0] {
                let mut trial = twist;
                trial[k] =
                    (twist[k] + sign * stride * reach[k]).clamp(start[k] - reach[k], start[k] + reach[k]);
                let residual = missed(trial);
                if size(&residual) < size(&best) {
                    (twist, best) = (trial, residual);
                }
            }
        }
        stride /= 2.0;
    }
    best
}
