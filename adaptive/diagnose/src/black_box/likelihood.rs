//! Likelihood of a recording under a black-box simulator with laws.
//!
//! Along the smoothed motion, the simulator is replaced by its first-order expansion ([`IntervalMap`]), so that
//! laws cost no calls of it. The wrench of a law is evaluated on the smoothed motion ([`mean_law_wrench`]).

use super::gains::{Gains, WindowPrediction};
use super::law_states::{InitialState, quadrature_nodes};
use super::law_wrench::{has_laws, law_wrench_covariance, mean_law_wrench};
use super::linearisation::{IntervalMap, defects, linearise};
use super::path::{Interval, Path};
use super::simulator::BlackBox;
use crate::block_bootstrap::{PredictedSample, PredictedSamples};
use nalgebra::{Matrix3, Vector3, Vector6};
use rayon::prelude::*;
use trundle_infer::{Channels, Fit, InferError, Watch};
use trundle_model::{MAX_INNER_STATES, Plant, Slot};
use trundle_record::Motion;

/// Likelihood along the smoothed paths of a recording's training episodes.
#[derive(Clone)]
pub(crate) struct PathLikelihood {
    pub dof: [bool; 3],
    pub channels: Channels,
    pub paths: Vec<Path>,
    pub(super) maps: Vec<Vec<IntervalMap>>,
    pub(super) gains: Vec<Gains>,
    /// Whitened innovations at [`PathLikelihood::values`], without laws.
    pub(super) base: Vec<f64>,
    /// Derivatives of the whitened innovations with respect to each free parameter of the simulator.
    pub(super) columns: Vec<Vec<f64>>,
    /// Parameters of the simulator. Given parameters have a value.
    pub parameters: Vec<Slot>,
    pub(super) free: Vec<usize>,
    /// Values of the simulator's parameters at which it is linearised.
    pub values: Vec<f64>,
    /// Covariance of the laws' wrench in each interval; empty without [`PathLikelihood::with_law_uncertainty`].
    law_covariances: Vec<Vec<Matrix3<f64>>>,
    /// The same likelihood of the first episodes, which ranks starts.
    pub(super) subset: Option<Box<PathLikelihood>>,
}

/// Factor by which a positive parameter may change before the simulator is linearised again.
const MAX_PARAMETER_FACTOR: f64 = 1.7;

/// Number of episodes of the subset that ranks starts.
const SUBSET_EPISODES: usize = 2;

impl PathLikelihood {
    /// Linearises a simulator along paths at values of its parameters.
    pub fn new(
        simulator: &BlackBox<'_>,
        values: &[f64],
        paths: &[Path],
        channels: Channels,
        dof: [bool; 3],
        watch: &dyn Watch,
    ) -> Result<Self, InferError> {
        let free: Vec<usize> =
            (0..simulator.parameters.len()).filter(|&k| simulator.parameters[k].value.is_none()).collect();
        let of = |path: &Path| linearise(simulator, values, &free, path, watch);
        let maps = paths.iter().map(of).collect::<Result<Vec<_>, InferError>>()?;
        let (paths, values, parameters) = (paths.to_vec(), values.to_vec(), simulator.parameters.clone());
        let unfiltered = Self {
            dof,
            channels,
            paths,
            maps,
            gains: vec![],
            base: vec![],
            columns: vec![],
            parameters,
            free,
            values,
            law_covariances: vec![],
            subset: None,
        };
        Ok(unfiltered.with_channels(channels).with_subset())
    }

    /// Adds the subset that ranks starts.
    #[must_use]
    pub fn with_subset(self) -> Self {
        let subset =
            (self.paths.len() > SUBSET_EPISODES).then(|| Box::new(self.only(|e| e < SUBSET_EPISODES)));
        Self { subset, ..self }
    }

    /// The same likelihood with another noise.
    #[must_use]
    pub fn with_channels(&self, channels: Channels) -> Self {
        let mut with = Self { channels, subset: None, ..self.clone() };
        with.gains =
            (0..with.paths.len()).into_par_iter().map(|e| with.gains_of(e, &channels, false)).collect();
        with.base =
            with.per_episode(|e| with.gains[e].whiten(|k| with.maps[e][k].defect, Some(&with.paths[e])));
        with.columns = (0..with.free.len())
            .map(|j| with.per_episode(|e| with.gains[e].whiten(|k| with.maps[e][k].slopes[j], None)))
            .collect();
        with
    }

    fn gains_of(&self, e: usize, channels: &Channels, keep_history: bool) -> Gains {
        let law_covariances = self.law_covariances.get(e).map_or(&[][..], Vec::as_slice);
        Gains::new(&self.paths[e], &self.maps[e], channels, self.dof, law_covariances, keep_history)
    }

    /// The same likelihood with the uncertainty of the laws' wrenches along the measured motion as additional process
    /// noise.
    #[must_use]
    pub fn with_law_uncertainty(&self, plant: &Plant<f64>, sim_values: &[f64]) -> Self {
        let initial = self.initial_states(plant, sim_values);
        let of = |(path, start): (&Path, &InitialState)| {
            let nodes = quadrature_nodes(plant, path, start.inner, usize::MAX);
            let at = |k: usize| nodes.get(k).map_or(&[][..], Vec::as_slice);
            path.intervals
                .iter()
                .enumerate()
                .map(|(k, interval)| law_wrench_covariance(plant, interval, at(k)))
                .collect()
        };
        let law_covariances = self.paths.par_iter().zip(&initial).map(of).collect();
        Self { law_covariances, subset: None, ..self.clone() }.with_channels(self.channels)
    }

    /// The likelihood of some episodes.
    #[must_use]
    pub fn only(&self, keep: impl Fn(usize) -> bool) -> Self {
        let kept: Vec<usize> = (0..self.paths.len()).filter(|&e| keep(e)).collect();
        let subset = Self {
            subset: None,
            law_covariances: kept.iter().filter_map(|&e| self.law_covariances.get(e).cloned()).collect(),
            paths: kept.iter().map(|&e| self.paths[e].clone()).collect(),
            maps: kept.iter().map(|&e| self.maps[e].clone()).collect(),
            ..self.clone()
        };
        subset.with_channels(self.channels)
    }

    fn per_episode(&self, of: impl Fn(usize) -> Vec<f64> + Sync + Send) -> Vec<f64> {
        (0..self.paths.len()).into_par_iter().map(of).collect::<Vec<_>>().concat()
    }

    /// Negative log density at other values of the simulator's parameters, from calls of the simulator, without laws.
    pub fn exact_cost(
        &self,
        simulator: &BlackBox<'_>,
        values: &[f64],
        watch: &dyn Watch,
    ) -> Result<f64, InferError> {
        let mut cost = 0.0;
        for (path, gains) in self.paths.iter().zip(&self.gains) {
            let defects = defects(simulator, values, path, watch)?;
            let innovations = gains.whiten(|k| defects[k], Some(path));
            cost += gains.normaliser + 0.5 * innovations.iter().map(|e| e * e).sum::<f64>();
        }
        Ok(if cost.is_finite() { cost } else { f64::INFINITY })
    }

    /// Values of the simulator's parameters in a fit.
    pub fn parameter_values(&self, fit: &Fit) -> Vec<f64> {
        let one = |(slot, &at): (&Slot, &f64)| {
            slot.value.or_else(|| fit.estimate(&slot.name).map(|e| e.mean)).unwrap_or(at)
        };
        self.parameters.iter().zip(&self.values).map(one).collect()
    }

    /// Number of measured poses.
    pub fn observations(&self) -> usize {
        self.paths.iter().map(|p| p.intervals.len()).sum()
    }

    /// Mean wrench that laws add to each of the first `count` intervals, object axes about the origin.
    fn law_wrenches(
        &self,
        plant: &Plant<f64>,
        e: usize,
        inner: &[f64; MAX_INNER_STATES],
        count: usize,
    ) -> Vec<[f64; 3]> {
        let path = &self.paths[e];
        let nodes = quadrature_nodes(plant, path, *inner, count);
        let at = |k: usize| nodes.get(k).map_or(&[][..], Vec::as_slice);
        let accel = |k: usize, i: &Interval| {
            [3, 4, 5].map(|row| (i.to[row] - i.from[row] + self.maps[e][k].defect[row]) / i.span)
        };
        let one = |(k, i): (usize, &Interval)| mean_law_wrench(plant, i, &path.readings, at(k), accel(k, i));
        path.intervals.iter().enumerate().take(count).map(one).collect()
    }

    /// Whitened innovations with laws and given values of the simulator's parameters.
    pub fn innovations(&self, plant: &Plant<f64>, sim_values: &[f64]) -> Vec<f64> {
        self.innovations_from(plant, sim_values, &self.initial_states(plant, sim_values))
    }

    pub(super) fn innovations_from(
        &self,
        plant: &Plant<f64>,
        sim_values: &[f64],
        initial: &[InitialState],
    ) -> Vec<f64> {
        let (laws, without) =
            (self.law_innovations(plant, initial), self.innovations_without_laws(sim_values));
        laws.iter().zip(&without).map(|(laws, without)| laws + without).collect()
    }

    /// Whitened innovations without laws.
    pub(super) fn innovations_without_laws(&self, sim_values: &[f64]) -> Vec<f64> {
        let mut sum = self.base.clone();
        for (&k, column) in self.free.iter().zip(&self.columns) {
            let change = self.parameter_change(k, sim_values);
            for (s, c) in sum.iter_mut().zip(column) {
                *s += change * c;
            }
        }
        sum
    }

    /// Change of a simulator parameter from its linearisation point. Positive parameters change on a logarithmic
    /// scale, so that they stay positive.
    fn parameter_change(&self, k: usize, sim_values: &[f64]) -> f64 {
        let (at, value) = (self.values[k], sim_values.get(k).copied().unwrap_or(self.values[k]));
        if self.is_positive(k) { at * (value.max(f64::MIN_POSITIVE) / at).ln() } else { value - at }
    }

    pub(super) fn is_positive(&self, k: usize) -> bool {
        self.parameters[k].lower >= 0.0 && self.values[k] > 0.0
    }

    /// Values of the simulator's parameters in a fit, limited to where the linearisation is trusted.
    pub fn trust_region_values(&self, fit: &Fit) -> Vec<f64> {
        let sim_values = self.parameter_values(fit);
        let one = |k: usize| {
            let at = self.values[k];
            if self.is_positive(k) {
                sim_values[k].clamp(at / MAX_PARAMETER_FACTOR, at * MAX_PARAMETER_FACTOR)
            } else {
                sim_values[k]
            }
        };
        (0..sim_values.len()).map(one).collect()
    }

    /// Change of the whitened innovations due to laws.
    pub(super) fn law_innovations(&self, plant: &Plant<f64>, initial: &[InitialState]) -> Vec<f64> {
        if !has_laws(plant) {
            return vec![0.0; self.base.len()];
        }
        self.per_episode(|e| self.law_innovations_in(plant, e, &initial[e].inner, usize::MAX))
    }

    /// Change due to laws in the first `count` intervals of an episode.
    pub(super) fn law_innovations_in(
        &self,
        plant: &Plant<f64>,
        e: usize,
        inner: &[f64; MAX_INNER_STATES],
        count: usize,
    ) -> Vec<f64> {
        let added = self.law_wrenches(plant, e, inner, count);
        self.gains[e].whiten_first(count, |k| self.maps[e][k].b * Vector3::from(added[k]), None)
    }

    /// Prediction of each interval.
    pub fn predicted(&self, plant: &Plant<f64>, sim_values: &[f64]) -> PredictedSamples {
        let initial = self.initial_states(plant, sim_values);
        let innovations = self.innovations_from(plant, sim_values, &initial);
        let mut remaining = innovations.as_slice();
        let mut all = Vec::with_capacity(self.paths.len());
        for ((path, gains), start) in self.paths.iter().zip(&self.gains).zip(&initial) {
            let (innovations_here, others) = remaining.split_at(3 * path.intervals.len());
            let share = (gains.normaliser + start.laplace_cost) / path.intervals.len() as f64;
            let one = |e: &[f64; 3]| PredictedSample {
                cost: share + 0.5 * e.iter().map(|e| e * e).sum::<f64>(),
                residual: *e,
            };
            all.push(innovations_here.as_chunks().0.iter().map(one).collect());
            remaining = others;
        }
        all
    }

    /// Missing wrench along every episode, as a random walk, in addition to the laws.
    pub fn residuals(
        &self,
        plant: &Plant<f64>,
        sim_values: &[f64],
        channels: Channels,
    ) -> Vec<Vec<trundle_infer::Residual>> {
        let initial = self.initial_states(plant, sim_values);
        let one = |e: usize| {
            let inputs = self.state_inputs(plant, sim_values, e, &initial[e].inner);
            self.gains_of(e, &channels, true).residuals(|k| inputs[k], &self.paths[e])
        };
        (0..self.paths.len()).into_par_iter().map(one).collect()
    }

    /// Covariances of open-loop predictions over consecutive spans of an episode.
    pub fn predict_windows(&self, e: usize, motion_so_far: &[Motion], seconds: f64) -> Vec<WindowPrediction> {
        self.gains_of(e, &self.channels, true).predict_windows(
            &self.paths[e],
            motion_so_far,
            &self.channels,
            seconds,
        )
    }

    /// Time at the end of each interval and the standard deviations of the pose predicted there.
    pub fn predicted_sds(&self) -> Vec<Vec<(f64, [f64; 3])>> {
        let one = |(path, gains): (&Path, &Gains)| {
            let sd = |interval: &Interval, v: [f64; 3]| {
                let noise = interval.pose_variance(&self.channels);
                [0, 1, 2].map(|k| (v[k] - noise[k]).max(0.0).sqrt())
            };
            path.intervals.iter().zip(gains.variances()).map(|(i, v)| (i.t + i.span, sd(i, v))).collect()
        };
        self.paths.iter().zip(&self.gains).map(one).collect()
    }

    /// Input that each interval of an episode adds to the deviation from the smoothed motion.
    fn state_inputs(
        &self,
        plant: &Plant<f64>,
        sim_values: &[f64],
        e: usize,
        inner: &[f64; MAX_INNER_STATES],
    ) -> Vec<Vector6<f64>> {
        let added = self.law_wrenches(plant, e, inner, usize::MAX);
        let one = |(map, added): (&IntervalMap, &[f64; 3])| {
            let mut sum: Vector6<f64> = map.defect + map.b * Vector3::from(*added);
            for (j, &slot) in self.free.iter().enumerate() {
                sum += map.slopes[j] * self.parameter_change(slot, sim_values);
            }
            sum
        };
        self.maps[e].iter().zip(&added).map(one).collect()
    }
}
