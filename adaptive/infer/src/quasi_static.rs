//! Likelihood of the wrench that a slow motion requires.
//!
//! Where inertia is far below friction, the force carries no information about the mass, and a simulation
//! driven by the force is ill-posed. This likelihood compares the wrench that the laws require for the
//! measured twist with the recorded wrench.

use crate::likelihood::{Likelihood, Linearised};
use crate::resting_readings::RestingReadings;
use crate::steady_segments::samples;
use crate::wrench_sample::WrenchSample;
use crate::{Channels, InferError};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;
use trundle_model::{Dual, EffectTarget, Model, Real, Slot, transport};
use trundle_record::{Noise, Prepared};

/// Compares required with recorded wrenches. The scatter of the difference is estimated.
#[derive(Clone)]
pub struct WrenchLikelihood {
    samples: Vec<WrenchSample>,
    episodes: Vec<String>,
    dof: [bool; 3],
    scatter: [f64; 3],
    resting: RestingReadings,
}

impl WrenchLikelihood {
    /// Likelihood of the given episodes. A continuous log gives one sample for each second of motion. A push
    /// with known end poses alone gives one sample.
    ///
    /// # Errors
    /// When fewer than three samples are found.
    pub fn new(episodes: &[Prepared], noise: &Noise, dof: [bool; 3]) -> Result<Self, InferError> {
        let samples: Vec<_> = episodes.iter().enumerate().flat_map(|(k, e)| samples(k, e, noise)).collect();
        if samples.len() < 3 {
            return Err(InferError::NoData {
                recording: "the recording".to_owned(),
                reason: format!(
                    "only {} steady segments of motion under a wrench are left; at least 3 are required",
                    samples.len()
                ),
                remedy: "record pushes that move the object further than the tracker's noise".to_owned(),
            });
        }
        let scatter = [0, 1, 2].map(|k| {
            let square: f64 = samples.iter().map(|s| transport(s.reading, s.frame)[k].powi(2)).sum();
            (square / samples.len() as f64).sqrt().max(1e-9)
        });
        let resting = RestingReadings::new(episodes, noise);
        let episodes = episodes.iter().map(|e| e.name.clone()).collect();
        Ok(Self { samples, episodes, dof, scatter: pooled(scatter), resting })
    }

    /// The samples.
    pub fn samples(&self) -> &[WrenchSample] {
        &self.samples
    }

    /// The same likelihood over given samples.
    #[must_use]
    pub fn over(&self, samples: &[WrenchSample]) -> Self {
        Self { samples: samples.to_vec(), ..self.clone() }
    }

    /// The same likelihood over a subset of the episodes.
    #[must_use]
    pub fn only(&self, keep: impl Fn(usize) -> bool) -> Self {
        let resting = self.resting.only(&keep);
        let samples = self.samples.iter().filter(|s| keep(s.episode)).cloned().collect();
        Self { samples, resting, ..self.clone() }
    }

    /// The same likelihood with a given scatter of required minus recorded wrench, N, N, N·m.
    #[must_use]
    pub fn with_scatter(&self, scatter: [f64; 3]) -> Self {
        Self { scatter, ..self.clone() }
    }

    /// Required minus recorded wrench of each sample, divided by its scatter; zero along blocked directions.
    ///
    /// # Errors
    /// When `values` has the wrong length.
    pub fn whitened(&self, model: &Model, values: &[f64]) -> Result<Vec<[f64; 3]>, InferError> {
        let plant = model.plant(values)?;
        let one = |sample: &WrenchSample| {
            let residual = sample.residual(&plant);
            [0, 1, 2].map(|k| if self.dof[k] { residual[k] / self.scatter[k] } else { 0.0 })
        };
        Ok(self.samples.iter().map(one).collect())
    }

    /// −log density of a sample with zero residual.
    pub fn log_normaliser(&self) -> f64 {
        (0..3).filter(|&k| self.dof[k]).map(|k| self.scatter[k].ln() + 0.5 * TAU.ln()).sum()
    }

    /// The same likelihood with the scatter estimated at the given values.
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

/// Pools the scatter of the forces along x and y.
fn pooled([x, y, torque]: [f64; 3]) -> [f64; 3] {
    let force = ((x * x + y * y) / 2.0).sqrt();
    [force, force, torque]
}

impl Likelihood for WrenchLikelihood {
    fn cost(&self, model: &Model, values: &[f64]) -> Result<f64, InferError> {
        let (whitened, constant) = (self.whitened(model, values)?, self.log_normaliser());
        let moving: f64 =
            whitened.iter().map(|w| 0.5 * w.iter().map(|e| e * e).sum::<f64>() + constant).sum();
        Ok(moving + self.resting.cost(model, values)?)
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
        let resting = self.resting.linearise(model, values, free)?;
        Ok(Linearised {
            cost: self.cost(model, values)?,
            gradient: jacobian.tr_mul(&whitened) + resting.gradient,
            curvature: jacobian.tr_mul(&jacobian) + resting.curvature,
        })
    }

    /// The required wrench is linear in the strengths of the laws. A search in their logarithms that starts
    /// far above the optimum may step down to strengths with almost no effect on the cost.
    fn rescaled(&self, model: &Model, values: &[f64]) -> Result<Option<Vec<f64>>, InferError> {
        let slots = model.slots();
        let is_strength = |slot: &Slot| {
            let of_object = |k: usize| model.effects[k].kind.spec().target == EffectTarget::Object;
            slot.value.is_none() && slot.unit.starts_with('N') && slot.effect.is_some_and(of_object)
        };
        let times = |factor: f64| -> Vec<f64> {
            let one = |(slot, &value): (&Slot, &f64)| {
                if is_strength(slot) { (factor * value).clamp(slot.lower, slot.upper) } else { value }
            };
            slots.iter().zip(values).map(one).collect()
        };
        let (once, twice) = (self.whitened(model, values)?, self.whitened(model, &times(2.0))?);
        let (mut own, mut cross) = (0.0, 0.0);
        for (a, b) in once.iter().flatten().zip(twice.iter().flatten()) {
            let (slope, rest) = (b - a, 2.0 * a - b);
            own += slope * slope;
            cross -= slope * rest;
        }
        let factor = cross / own;
        Ok((factor.is_finite() && factor > 0.0).then(|| times(factor)))
    }

    fn channels(&self) -> Channels {
        Channels { pose: [0.0; 3], reading: self.scatter, wander: [0.0; 3] }
    }

    fn split(&self) -> Vec<(String, Box<dyn Likelihood + '_>)> {
        let one = |k: usize| {
            let alone: Box<dyn Likelihood> = Box::new(self.only(|episode| episode == k));
            (self.episodes[k].clone(), alone)
        };
        (0..self.episodes.len()).map(one).collect()
    }

    fn tuned(&self, model: &Model, values: &[f64]) -> Result<Option<Box<dyn Likelihood + '_>>, InferError> {
        Ok(Some(Box::new(self.with_tuned_noise(model, values)?)))
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use trundle_model::{Body, Clock, Effect, Kind};

    #[test]
    fn strengths_are_rescaled_to_fit_the_data() {
        let body = Body::from_footprint(&[[-0.2, -0.2], [0.2, -0.2], [0.2, 0.2], [-0.2, 0.2]], 1.0).unwrap();
        let model =
            Model { effects: vec![Effect::free(Kind::SupportDrag)], ..Model::nominal(body, None, [true; 3]) };
        let drag = model.slots().iter().position(|slot| slot.name == "support_drag.mu").unwrap();
        let middle = crate::Coordinates::new(&model);
        let mut values = middle.values(&vec![0.0; middle.free().len()]).0;
        values[drag] = 30.0;
        let plant = model.plant(&values).unwrap();
        let sample = |k: usize| {
            let twist = [0.01 * (k as f64).cos(), 0.01 * (k as f64).sin(), 0.02];
            let unloaded = WrenchSample {
                episode: 0,
                t: k as f64,
                pose: [0.0; 3],
                twist,
                reading: [0.0; 3],
                frame: [0.0; 3],
                clock: Clock::since_contact(1.0),
            };
            WrenchSample { reading: unloaded.needed(&plant), ..unloaded }
        };
        let likelihood = WrenchLikelihood {
            samples: (0..8).map(sample).collect(),
            episodes: vec!["log".to_owned()],
            dof: [true; 3],
            scatter: [1.0; 3],
            resting: RestingReadings::default(),
        };
        for start in [3e-3, 30.0, 4e4] {
            values[drag] = start;
            let found = likelihood.rescaled(&model, &values).unwrap().unwrap();
            assert!((found[drag] / 30.0 - 1.0).abs() < 1e-9, "{}", found[drag]);
        }
    }
}
