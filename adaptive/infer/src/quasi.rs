//! The likelihood of the wrench that a slow motion needs.
//!
//! When inertia is far below friction, the force says nothing of the mass and a simulation driven
//! by it is ill-posed: at the limit any motion fits. What can be compared is the wrench
//! that the laws need for the twist that was seen with the wrench that was recorded.

use crate::likelihood::{Likelihood, Linearised};
use crate::{Channels, InferError};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;
use trundle_model::{Clock, Dual, Model, Plant, Real, State, to_body, transport};
use trundle_record::{Motion, Noise, Prepared};

/// Twist and wrench averaged over a short time.
#[derive(Clone, Debug)]
pub struct WrenchSample {
    /// Index of the episode.
    pub episode: usize,
    /// Middle of the interval, s.
    pub t: f64,
    /// Pose of the object.
    pub pose: [f64; 3],
    /// Its twist, world axes.
    pub twist: [f64; 3],
    /// Mean reading, reading axes.
    pub reading: [f64; 3],
    /// Pose of the reading frame in the object frame.
    pub frame: [f64; 3],
    /// When.
    pub clock: Clock,
}

impl WrenchSample {
    fn state<T: Real>(&self) -> State<T> {
        State { pose: self.pose.map(T::lift), twist: self.twist.map(T::lift) }
    }

    /// The recorded wrench as a model's instruments explain it, object axes about the origin.
    pub fn recorded<T: Real>(&self, plant: &Plant<T>) -> [T; 3] {
        transport(plant.correct(self.reading.map(T::lift), self.clock), self.frame)
    }

    /// The wrench that a model needs for the twist, object axes about the origin.
    pub fn needed<T: Real>(&self, plant: &Plant<T>) -> [T; 3] {
        let state = self.state();
        let twist = to_body(state.twist, state.pose[2]);
        plant.action(&state, self.clock).wrench(twist).map(|w| -w)
    }

    /// Needed less recorded.
    pub fn residual<T: Real>(&self, plant: &Plant<T>) -> [T; 3] {
        let (needed, recorded) = (self.needed(plant), self.recorded(plant));
        [0, 1, 2].map(|k| needed[k] - recorded[k])
    }
}

/// Wrenches needed and recorded, with the scatter of the difference estimated.
#[derive(Clone)]
pub struct WrenchLikelihood {
    samples: Vec<WrenchSample>,
    dof: [bool; 3],
    scatter: [f64; 3],
}

/// Averaging time for continuous logs, s: several pose samples, and short against the pushes.
const BIN: f64 = 0.25;

/// Acceleration below which a motion is quasi-static, m/s²: a tenth of a friction with μ = 0.05.
const SLOW: f64 = 0.05;

/// Whether inertia plays no part in these episodes.
pub fn is_quasi_static(episodes: &[Prepared], noise: &Noise) -> bool {
    let (mut square, mut count) = (0.0, 0.0);
    for episode in episodes {
        if episode.pose.len() < 5 {
            return true;
        }
        for m in episode.motion(noise).iter().filter(|m| m.t >= episode.contact) {
            let seen = m.accel[0].powi(2) + m.accel[1].powi(2);
            square += seen - m.cov[0][2][2] - m.cov[1][2][2];
            count += 1.0;
        }
    }
    count == 0.0 || square / count < SLOW * SLOW
}

impl WrenchLikelihood {
    /// From the episodes to be fitted; each continuous log gives a sample per quarter second of
    /// motion, each push with end poses alone gives one.
    ///
    /// # Errors
    /// When nothing moves.
    pub fn new(episodes: &[Prepared], noise: &Noise, dof: [bool; 3]) -> Result<Self, InferError> {
        let samples: Vec<_> = episodes.iter().enumerate().flat_map(|(k, e)| samples(k, e, noise)).collect();
        if samples.len() < 3 {
            return Err(InferError::NoData {
                recording: "the recording".to_owned(),
                reason: format!("only {} stretches of motion under a wrench are left", samples.len()),
                remedy: "record pushes that move the object further than the tracker's noise".to_owned(),
            });
        }
        let scatter = [0, 1, 2].map(|k| {
            let square: f64 = samples.iter().map(|s| transport(s.reading, s.frame)[k].powi(2)).sum();
            (square / samples.len() as f64).sqrt().max(1e-9)
        });
        Ok(Self { samples, dof, scatter: pooled(scatter) })
    }

    /// The samples.
    pub fn samples(&self) -> &[WrenchSample] {
        &self.samples
    }

    /// The same over some of its samples.
    #[must_use]
    pub fn over(&self, samples: &[WrenchSample]) -> Self {
        Self { samples: samples.to_vec(), ..*self }
    }

    /// The same with some of its episodes.
    #[must_use]
    pub fn only(&self, keep: impl Fn(usize) -> bool) -> Self {
        Self { samples: self.samples.iter().filter(|s| keep(s.episode)).cloned().collect(), ..*self }
    }

    /// The same with a given scatter of needed less recorded, N, N, N·m.
    #[must_use]
    pub fn with_scatter(&self, scatter: [f64; 3]) -> Self {
        Self { scatter, ..self.clone() }
    }

    /// The same with the scatter of needed less recorded found at these values.
    ///
    /// # Errors
    /// When `values` has the wrong length.
    pub fn with_tuned_noise(&self, model: &Model, values: &[f64]) -> Result<Self, InferError> {
        let plant = model.plant(values)?;
        let mut square = [0.0; 3];
        for residual in self.samples.iter().map(|s| s.residual(&plant)) {
            for k in 0..3 {
                square[k] += residual[k] * residual[k];
            }
        }
        let scatter = square.map(|s| (s / self.samples.len() as f64).sqrt().max(1e-9));
        Ok(Self { scatter: pooled(scatter), ..self.clone() })
    }
}

/// Forces along x and y scatter alike.
fn pooled([x, y, torque]: [f64; 3]) -> [f64; 3] {
    let force = ((x * x + y * y) / 2.0).sqrt();
    [force, force, torque]
}

impl Likelihood for WrenchLikelihood {
    fn cost(&self, model: &Model, values: &[f64]) -> Result<f64, InferError> {
        let plant = model.plant(values)?;
        let constant: f64 =
            (0..3).filter(|&k| self.dof[k]).map(|k| self.scatter[k].ln() + 0.5 * TAU.ln()).sum();
        let square = |s: &WrenchSample| {
            let residual = s.residual(&plant);
            (0..3).filter(|&k| self.dof[k]).map(|k| (residual[k] / self.scatter[k]).powi(2)).sum::<f64>()
        };
        Ok(self.samples.iter().map(|s| 0.5 * square(s) + constant).sum())
    }

    fn linearise(&self, model: &Model, values: &[f64], free: &[usize]) -> Result<Linearised, InferError> {
        const WIDTH: usize = 8;
        let rows = 3 * self.samples.len();
        let mut jacobian = DMatrix::zeros(rows, free.len());
        let mut whitened = DVector::zeros(rows);
        for (chunk, slots) in free.chunks(WIDTH).enumerate() {
            let mut lifted: Vec<Dual<WIDTH>> = values.iter().map(|&v| Real::lift(v)).collect();
            for (k, &slot) in slots.iter().enumerate() {
                lifted[slot] = Dual::variable(values[slot], k);
            }
            let plant = model.plant(&lifted)?;
            for (i, sample) in self.samples.iter().enumerate() {
                let residual = sample.residual(&plant);
                for k in (0..3).filter(|&k| self.dof[k]) {
                    whitened[3 * i + k] = residual[k].re / self.scatter[k];
                    for (j, slope) in residual[k].eps[..slots.len()].iter().enumerate() {
                        jacobian[(3 * i + k, chunk * WIDTH + j)] = slope / self.scatter[k];
                    }
                }
            }
        }
        Ok(Linearised {
            cost: self.cost(model, values)?,
            gradient: jacobian.tr_mul(&whitened),
            curvature: jacobian.tr_mul(&jacobian),
        })
    }

    fn channels(&self) -> Channels {
        Channels { pose: [0.0; 3], reading: self.scatter, wander: [0.0; 3] }
    }

    fn tuned(&self, model: &Model, values: &[f64]) -> Result<Option<Box<dyn Likelihood + '_>>, InferError> {
        Ok(Some(Box::new(self.with_tuned_noise(model, values)?)))
    }
}

/// The stretches of one episode in which a wrench moves the object.
pub fn wrench_samples(episode: &Prepared, noise: &Noise) -> Vec<WrenchSample> {
    samples(0, episode, noise)
}

fn samples(index: usize, episode: &Prepared, noise: &Noise) -> Vec<WrenchSample> {
    if episode.pose.len() < 5 {
        whole_push(index, episode).into_iter().collect()
    } else {
        bins(index, episode, noise)
    }
}

/// Size of a wrench in an episode below which the gripper does not push: a fifth of the median
/// load from contact on.
fn load_threshold(episode: &Prepared) -> f64 {
    let mut loads: Vec<f64> =
        episode.wrench.iter().filter(|w| w.t >= episode.contact).map(|w| size(w.reading)).collect();
    loads.sort_by(f64::total_cmp);
    loads.get(loads.len() / 2).map_or(f64::INFINITY, |m| 0.2 * m)
}

fn size([x, y, _]: [f64; 3]) -> f64 {
    x.hypot(y)
}

/// A continuous log: means over bins in which it is pushed and moves.
fn bins(index: usize, episode: &Prepared, noise: &Noise) -> Vec<WrenchSample> {
    let threshold = load_threshold(episode);
    let motion = episode.motion(noise);
    let mut samples = Vec::new();
    let mut rest = motion.as_slice();
    while let Some(first) = rest.first() {
        let count = rest.partition_point(|m| m.t < first.t + BIN);
        let (bin, after) = rest.split_at(count);
        rest = after;
        let end = first.t + BIN;
        let readings: Vec<_> = episode.wrench.iter().filter(|w| w.t >= first.t && w.t < end).collect();
        let gapless = bin.len() >= 3 && readings.len() >= 3;
        if first.t < episode.contact || !gapless || !moves(bin) {
            continue;
        }
        let mean = |value: &dyn Fn(&Motion) -> f64| bin.iter().map(value).sum::<f64>() / bin.len() as f64;
        let reading =
            [0, 1, 2].map(|k| readings.iter().map(|w| w.reading[k]).sum::<f64>() / readings.len() as f64);
        if size(reading) < threshold {
            continue;
        }
        let middle = first.t + BIN / 2.0;
        samples.push(WrenchSample {
            episode: index,
            t: middle,
            pose: [0, 1, 2].map(|k| mean(&|m| m.pose[k])),
            twist: [0, 1, 2].map(|k| mean(&|m| m.twist[k])),
            reading,
            frame: readings[readings.len() / 2].frame,
            clock: Clock { since_contact: middle - episode.contact },
        });
    }
    samples
}

/// Whether a stretch moves by more than its velocity's uncertainty.
fn moves(bin: &[Motion]) -> bool {
    let n = bin.len() as f64;
    let signal: f64 = (0..3)
        .map(|k| {
            let mean = bin.iter().map(|m| m.twist[k]).sum::<f64>() / n;
            let variance = bin.iter().map(|m| m.cov[k][1][1]).sum::<f64>() / n;
            mean * mean / variance.max(1e-18)
        })
        .sum();
    signal > 25.0
}

/// A push of which only the poses before and after are known: the mean twist while it lasted, and
/// the mean wrench over it, its frame followed along the straight way between the two poses.
fn whole_push(index: usize, episode: &Prepared) -> Option<WrenchSample> {
    let (first, last) = (episode.pose.first()?, episode.pose.last()?);
    let threshold = load_threshold(episode);
    let pushing: Vec<_> =
        episode.wrench.iter().filter(|w| w.t >= episode.contact && size(w.reading) > threshold).collect();
    let (begin, end) = (pushing.first()?.t, pushing.last()?.t);
    let duration = end - begin;
    if pushing.len() < 5 || duration <= 0.0 {
        return None;
    }
    let change = [0, 1, 2].map(|k| last.pose[k] - first.pose[k]);
    let at = |t: f64| {
        let share = ((t - begin) / duration).clamp(0.0, 1.0);
        [0, 1, 2].map(|k| first.pose[k] + share * change[k])
    };
    let pose = at((begin + end) / 2.0);
    let n = pushing.len() as f64;
    let mut wrench = [0.0; 3];
    for sample in &pushing {
        // The frame was found with the first pose; follow the object to where it is by now.
        let frame = relative(compose(first.pose, sample.frame), at(sample.t));
        let on_object = transport(sample.reading, frame);
        for k in 0..3 {
            wrench[k] += on_object[k] / n;
        }
    }
    let clock = Clock { since_contact: (begin + end) / 2.0 - episode.contact };
    let twist = change.map(|c| c / duration);
    Some(WrenchSample {
        episode: index,
        t: (begin + end) / 2.0,
        pose,
        twist,
        reading: wrench,
        frame: [0.0; 3],
        clock,
    })
}

/// Pose of `inner`, given in `outer`, in the world.
fn compose(outer: [f64; 3], inner: [f64; 3]) -> [f64; 3] {
    let (sin, cos) = outer[2].sin_cos();
    [
        outer[0] + cos * inner[0] - sin * inner[1],
        outer[1] + sin * inner[0] + cos * inner[1],
        outer[2] + inner[2],
    ]
}

/// A world pose as seen from `from`.
fn relative(pose: [f64; 3], from: [f64; 3]) -> [f64; 3] {
    let d = to_body([pose[0] - from[0], pose[1] - from[1], 0.0], from[2]);
    [d[0], d[1], pose[2] - from[2]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn relative_undoes_compose() {
        let (outer, inner) = ([1.0, -2.0, 0.7], [0.3, 0.1, -0.2]);
        for (a, b) in relative(compose(outer, inner), outer).iter().zip(inner) {
            assert!((a - b).abs() < 1e-12);
        }
    }
}
