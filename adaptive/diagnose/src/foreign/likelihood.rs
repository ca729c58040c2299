//! What a recording says of laws that are added to a foreign simulator's input, and of its own parameters.
//!
//! Along the smoothed motion the simulator is replaced by what it is to first order ([`Map`]); so a law costs no call of it.
//! A law's wrench is that at the smoothed motion ([`added`]).

use super::gains::{Ahead, Gains};
use super::law::{acts, added, doubted};
use super::linear::{Map, gaps, linearise};
use super::own_states::{Start, moments};
use super::path::{Interval, Path};
use super::simulator::Foreign;
use crate::block_bootstrap::{PredictedSample, PredictedSamples};
use nalgebra::{Matrix3, Vector3, Vector6};
use rayon::prelude::*;
use trundle_infer::{Channels, Fit, InferError, Watch};
use trundle_model::{MAX_INNER_STATES, Plant, Slot};
use trundle_record::Motion;

/// A recording's paths with everything that the laws and parameters are compared by.
#[derive(Clone)]
pub(crate) struct Along {
    pub dof: [bool; 3],
    pub channels: Channels,
    pub paths: Vec<Path>,
    pub(super) maps: Vec<Vec<Map>>,
    pub(super) gains: Vec<Gains>,
    /// Whitened innovations at [`Along::values`], without laws.
    pub(super) base: Vec<f64>,
    /// What each free parameter of the simulator changes in them, per unit.
    pub(super) columns: Vec<Vec<f64>>,
    /// The simulator's parameters, those that are given having their value.
    pub parameters: Vec<Slot>,
    pub(super) free: Vec<usize>,
    /// Values of its parameters at which it is linearised.
    pub values: Vec<f64>,
    /// Covariance of what laws add to each interval, where a law was asked for it.
    doubts: Vec<Vec<Matrix3<f64>>>,
    /// The same over its first episodes, to sort starts with.
    pub(super) sketch: Option<Box<Along>>,
}

/// By what factor a positive parameter may move before the simulator is asked anew.
const FACTOR: f64 = 1.7;

/// Episodes of a sketch.
const SKETCHED: usize = 2;

impl Along {
    /// Linearise a simulator along paths at values of its parameters.
    pub fn new(
        foreign: &Foreign<'_>,
        values: &[f64],
        paths: &[Path],
        channels: Channels,
        dof: [bool; 3],
        watch: &dyn Watch,
    ) -> Result<Self, InferError> {
        let free: Vec<usize> =
            (0..foreign.parameters.len()).filter(|&k| foreign.parameters[k].value.is_none()).collect();
        let of = |path: &Path| linearise(foreign, values, &free, path, watch);
        let maps = paths.iter().map(of).collect::<Result<Vec<_>, InferError>>()?;
        let (paths, values, parameters) = (paths.to_vec(), values.to_vec(), foreign.parameters.clone());
        let empty = Self {
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
            doubts: vec![],
            sketch: None,
        };
        Ok(empty.with_channels(channels).sketched())
    }

    /// The same with what starts are sorted with.
    #[must_use]
    pub fn sketched(self) -> Self {
        let sketch = (self.paths.len() > SKETCHED).then(|| Box::new(self.only(|e| e < SKETCHED)));
        Self { sketch, ..self }
    }

    /// The same with other noise.
    #[must_use]
    pub fn with_channels(&self, channels: Channels) -> Self {
        let mut with = Self { channels, sketch: None, ..self.clone() };
        with.gains =
            (0..with.paths.len()).into_par_iter().map(|e| with.gains_of(e, &channels, false)).collect();
        with.base = with.each(|e| with.gains[e].whiten(|k| with.maps[e][k].gap, Some(&with.paths[e])));
        with.columns = (0..with.free.len())
            .map(|j| with.each(|e| with.gains[e].whiten(|k| with.maps[e][k].slopes[j], None)))
            .collect();
        with
    }

    fn gains_of(&self, e: usize, channels: &Channels, kept: bool) -> Gains {
        let doubts = self.doubts.get(e).map_or(&[][..], Vec::as_slice);
        Gains::new(&self.paths[e], &self.maps[e], channels, self.dof, doubts, kept)
    }

    /// The same where laws are trusted only as far as the seen motion tells what they do.
    #[must_use]
    pub fn doubting(&self, plant: &Plant<f64>, own: &[f64]) -> Self {
        let starts = self.starts(plant, own);
        let of = |(path, start): (&Path, &Start)| {
            let moments = moments(plant, path, start.inner, usize::MAX);
            let at = |k: usize| moments.get(k).map_or(&[][..], Vec::as_slice);
            path.intervals.iter().enumerate().map(|(k, interval)| doubted(plant, interval, at(k))).collect()
        };
        let doubts = self.paths.par_iter().zip(&starts).map(of).collect();
        Self { doubts, sketch: None, ..self.clone() }.with_channels(self.channels)
    }

    /// Some of its episodes.
    #[must_use]
    pub fn only(&self, keep: impl Fn(usize) -> bool) -> Self {
        let kept: Vec<usize> = (0..self.paths.len()).filter(|&e| keep(e)).collect();
        let some = Self {
            sketch: None,
            doubts: kept.iter().filter_map(|&e| self.doubts.get(e).cloned()).collect(),
            paths: kept.iter().map(|&e| self.paths[e].clone()).collect(),
            maps: kept.iter().map(|&e| self.maps[e].clone()).collect(),
            ..self.clone()
        };
        some.with_channels(self.channels)
    }

    fn each(&self, of: impl Fn(usize) -> Vec<f64> + Sync + Send) -> Vec<f64> {
        (0..self.paths.len()).into_par_iter().map(of).collect::<Vec<_>>().concat()
    }

    /// −log density at other values of the simulator's parameters, asked of the simulator itself; no laws.
    pub fn exactly(
        &self,
        foreign: &Foreign<'_>,
        values: &[f64],
        watch: &dyn Watch,
    ) -> Result<f64, InferError> {
        let mut cost = 0.0;
        for (path, gains) in self.paths.iter().zip(&self.gains) {
            let gaps = gaps(foreign, values, path, watch)?;
            let innovations = gains.whiten(|k| gaps[k], Some(path));
            cost += gains.normaliser + 0.5 * innovations.iter().map(|e| e * e).sum::<f64>();
        }
        Ok(if cost.is_finite() { cost } else { f64::INFINITY })
    }

    /// Values of the simulator's parameters in a fit.
    pub fn own(&self, fit: &Fit) -> Vec<f64> {
        let one = |(slot, &at): (&Slot, &f64)| {
            slot.value.or_else(|| fit.estimate(&slot.name).map(|e| e.mean)).unwrap_or(at)
        };
        self.parameters.iter().zip(&self.values).map(one).collect()
    }

    /// Number of innovations.
    pub fn observations(&self) -> usize {
        self.paths.iter().map(|p| p.intervals.len()).sum()
    }

    /// Mean wrench that laws add to each of the first `count` intervals, object axes about the origin.
    fn added(
        &self,
        plant: &Plant<f64>,
        e: usize,
        inner: &[f64; MAX_INNER_STATES],
        count: usize,
    ) -> Vec<[f64; 3]> {
        let path = &self.paths[e];
        let moments = moments(plant, path, *inner, count);
        let at = |k: usize| moments.get(k).map_or(&[][..], Vec::as_slice);
        let alone = |k: usize, i: &Interval| {
            [3, 4, 5].map(|row| (i.to[row] - i.from[row] + self.maps[e][k].gap[row]) / i.span)
        };
        let one = |(k, i): (usize, &Interval)| added(plant, i, &path.readings, at(k), alone(k, i));
        path.intervals.iter().enumerate().take(count).map(one).collect()
    }

    /// Whitened innovations with laws and values of the simulator's parameters.
    pub fn innovations(&self, plant: &Plant<f64>, own: &[f64]) -> Vec<f64> {
        self.innovations_from(plant, own, &self.starts(plant, own))
    }

    pub(super) fn innovations_from(&self, plant: &Plant<f64>, own: &[f64], starts: &[Start]) -> Vec<f64> {
        let (laws, without) = (self.of_laws(plant, starts), self.without_laws(own));
        laws.iter().zip(&without).map(|(laws, without)| laws + without).collect()
    }

    /// The same without laws.
    pub(super) fn without_laws(&self, own: &[f64]) -> Vec<f64> {
        let mut sum = self.base.clone();
        for (&k, column) in self.free.iter().zip(&self.columns) {
            let change = self.change(k, own);
            for (s, c) in sum.iter_mut().zip(column) {
                *s += change * c;
            }
        }
        sum
    }

    /// By how much a parameter of the simulator has moved; of one that is positive the logarithm, so that it stays so.
    fn change(&self, k: usize, own: &[f64]) -> f64 {
        let (at, value) = (self.values[k], own.get(k).copied().unwrap_or(self.values[k]));
        if self.is_positive(k) { at * (value.max(f64::MIN_POSITIVE) / at).ln() } else { value - at }
    }

    pub(super) fn is_positive(&self, k: usize) -> bool {
        self.parameters[k].lower >= 0.0 && self.values[k] > 0.0
    }

    /// Values of the simulator's parameters in a fit, no further from here than it is to be trusted.
    pub fn trusted(&self, fit: &Fit) -> Vec<f64> {
        let own = self.own(fit);
        let one = |k: usize| {
            let at = self.values[k];
            if self.is_positive(k) { own[k].clamp(at / FACTOR, at * FACTOR) } else { own[k] }
        };
        (0..own.len()).map(one).collect()
    }

    /// What laws change in them.
    pub(super) fn of_laws(&self, plant: &Plant<f64>, starts: &[Start]) -> Vec<f64> {
        if !acts(plant) {
            return vec![0.0; self.base.len()];
        }
        self.each(|e| self.of_laws_in(plant, e, &starts[e].inner, usize::MAX))
    }

    /// The same in the first `count` intervals of an episode.
    pub(super) fn of_laws_in(
        &self,
        plant: &Plant<f64>,
        e: usize,
        inner: &[f64; MAX_INNER_STATES],
        count: usize,
    ) -> Vec<f64> {
        let added = self.added(plant, e, inner, count);
        self.gains[e].whiten_first(count, |k| self.maps[e][k].b * Vector3::from(added[k]), None)
    }

    /// How each interval is predicted.
    pub fn predicted(&self, plant: &Plant<f64>, own: &[f64]) -> PredictedSamples {
        let starts = self.starts(plant, own);
        let innovations = self.innovations_from(plant, own, &starts);
        let mut rest = innovations.as_slice();
        let mut all = Vec::with_capacity(self.paths.len());
        for ((path, gains), start) in self.paths.iter().zip(&self.gains).zip(&starts) {
            let (mine, others) = rest.split_at(3 * path.intervals.len());
            let share = (gains.normaliser + start.price) / path.intervals.len() as f64;
            let one = |e: &[f64; 3]| PredictedSample {
                cost: share + 0.5 * e.iter().map(|e| e * e).sum::<f64>(),
                residual: *e,
            };
            all.push(mine.as_chunks().0.iter().map(one).collect());
            rest = others;
        }
        all
    }

    /// The missing wrench along every episode when it is let wander, with what is already explained.
    pub fn residuals(
        &self,
        plant: &Plant<f64>,
        own: &[f64],
        channels: Channels,
    ) -> Vec<Vec<trundle_infer::Residual>> {
        let starts = self.starts(plant, own);
        let one = |e: usize| {
            let inputs = self.inputs(plant, own, e, &starts[e].inner);
            self.gains_of(e, &channels, true).residuals(|k| inputs[k], &self.paths[e])
        };
        (0..self.paths.len()).into_par_iter().map(one).collect()
    }

    /// Simulations over successive spans of an episode: how uncertain they are.
    pub fn ahead(&self, e: usize, known: &[Motion], seconds: f64) -> Vec<Ahead> {
        self.gains_of(e, &self.channels, true).ahead(&self.paths[e], known, &self.channels, seconds)
    }

    /// Standard deviations of the poses that are predicted at the end of each interval, with its time.
    pub fn spreads(&self) -> Vec<Vec<(f64, [f64; 3])>> {
        let own = self.channels.pose.map(|s| s * s);
        let one = |(path, gains): (&Path, &Gains)| {
            let sd = |v: [f64; 3]| [0, 1, 2].map(|k| (v[k] - own[k]).max(0.0).sqrt());
            path.intervals.iter().zip(gains.variances()).map(|(i, v)| (i.t + i.span, sd(v))).collect()
        };
        self.paths.iter().zip(&self.gains).map(one).collect()
    }

    /// What each interval of an episode adds to the deviation from the seen motion.
    fn inputs(
        &self,
        plant: &Plant<f64>,
        own: &[f64],
        e: usize,
        inner: &[f64; MAX_INNER_STATES],
    ) -> Vec<Vector6<f64>> {
        let added = self.added(plant, e, inner, usize::MAX);
        let one = |(map, added): (&Map, &[f64; 3])| {
            let mut sum: Vector6<f64> = map.gap + map.b * Vector3::from(*added);
            for (j, &slot) in self.free.iter().enumerate() {
                sum += map.slopes[j] * self.change(slot, own);
            }
            sum
        };
        self.maps[e].iter().zip(&added).map(one).collect()
    }
}
