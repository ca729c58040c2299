//! What a recording says of laws that are added to a foreign simulator's input, and of its own parameters.
//!
//! Along the smoothed motion the simulator is replaced by what it is to first order ([`Map`]); so a law costs no call of it.
//! A law's wrench is that at the smoothed motion ([`added`]).

use super::gains::{Ahead, Gains};
use super::law::{added, doubted};
use super::linear::{Map, gaps, linearise};
use super::path::{Interval, Path};
use super::simulator::Foreign;
use crate::confirm::{Predicted, Samples};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3, Vector6};
use rayon::prelude::*;
use trundle_infer::{Channels, Fit, InferError, Likelihood, Linearised, Watch};
use trundle_model::{Model, Plant, Slot};
use trundle_record::Motion;

/// A recording's paths with everything that the laws and parameters are compared by.
#[derive(Clone)]
pub(crate) struct Along {
    pub dof: [bool; 3],
    pub channels: Channels,
    pub paths: Vec<Path>,
    maps: Vec<Vec<Map>>,
    gains: Vec<Gains>,
    /// Whitened innovations at [`Along::values`], without laws.
    base: Vec<f64>,
    /// What each free parameter of the simulator changes in them, per unit.
    columns: Vec<Vec<f64>>,
    /// The simulator's parameters, those that are given having their value.
    pub parameters: Vec<Slot>,
    free: Vec<usize>,
    /// Values of its parameters at which it is linearised.
    pub values: Vec<f64>,
    /// Covariance of what laws add to each interval, where a law was asked for it.
    doubts: Vec<Vec<Matrix3<f64>>>,
    /// The same over its first episodes, to sort starts with.
    sketch: Option<Box<Along>>,
}

/// By what factor a positive parameter may move before the simulator is asked anew.
const FACTOR: f64 = 1.7;

/// Episodes of a sketch.
const SKETCHED: usize = 2;

/// Step of a finite difference by a law's parameter, in what its prior takes for its scale.
const RELATIVE: f64 = 1e-4;

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
    pub fn doubting(&self, plant: &Plant<f64>) -> Self {
        let of = |path: &Path| path.intervals.iter().map(|interval| doubted(plant, interval)).collect();
        let doubts = self.paths.par_iter().map(of).collect();
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

    /// Mean wrench that laws add to each interval, object axes about the origin.
    fn added(&self, plant: &Plant<f64>, e: usize) -> Vec<[f64; 3]> {
        let path = &self.paths[e];
        path.intervals.iter().map(|interval| added(plant, interval, &path.recorded)).collect()
    }

    /// Whitened innovations with laws and values of the simulator's parameters.
    pub fn innovations(&self, plant: &Plant<f64>, own: &[f64]) -> Vec<f64> {
        let mut sum = self.of_laws(plant);
        for (s, b) in sum.iter_mut().zip(&self.base) {
            *s += b;
        }
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

    fn is_positive(&self, k: usize) -> bool {
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
    fn of_laws(&self, plant: &Plant<f64>) -> Vec<f64> {
        if plant.laws.is_empty() {
            return vec![0.0; self.base.len()];
        }
        self.each(|e| {
            let added = self.added(plant, e);
            self.gains[e].whiten(|k| self.maps[e][k].b * Vector3::from(added[k]), None)
        })
    }

    /// How each interval is predicted.
    pub fn predicted(&self, plant: &Plant<f64>, own: &[f64]) -> Samples {
        let innovations = self.innovations(plant, own);
        let mut rest = innovations.as_slice();
        let mut all = Vec::with_capacity(self.paths.len());
        for (path, gains) in self.paths.iter().zip(&self.gains) {
            let (mine, others) = rest.split_at(3 * path.intervals.len());
            let share = gains.normaliser / path.intervals.len() as f64;
            let one = |e: &[f64; 3]| Predicted {
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
        let one = |e: usize| {
            let inputs = self.inputs(plant, own, e);
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
    fn inputs(&self, plant: &Plant<f64>, own: &[f64], e: usize) -> Vec<Vector6<f64>> {
        let added = self.added(plant, e);
        let one = |(map, added): (&Map, &[f64; 3])| {
            let mut sum: Vector6<f64> = map.gap + map.b * Vector3::from(*added);
            for (j, &slot) in self.free.iter().enumerate() {
                sum += map.slopes[j] * self.change(slot, own);
            }
            sum
        };
        self.maps[e].iter().zip(&added).map(one).collect()
    }

    /// Mass that the wrench moves, kg: the median over all intervals.
    pub fn felt_mass(&self) -> Option<f64> {
        let pairs = self.paths.iter().zip(&self.maps).flat_map(|(p, m)| p.intervals.iter().zip(m));
        let mut all: Vec<f64> = pairs.filter_map(|(interval, map)| felt(interval, map)).collect();
        all.sort_by(f64::total_cmp);
        all.get(all.len() / 2).copied()
    }

    fn parted<'v>(&self, model: &Model, values: &'v [f64]) -> Result<(&'v [f64], &'v [f64]), InferError> {
        let (own, got) = (model.slots().len(), values.len());
        let expected = own + self.parameters.len();
        if got != expected {
            return Err(trundle_model::ModelError::Length { what: "parameters", got, expected }.into());
        }
        Ok(values.split_at(own))
    }

    /// Derivatives of the innovations by the slots `free`: the model's, then the simulator's.
    pub fn jacobian(
        &self,
        model: &Model,
        values: &[f64],
        free: &[usize],
    ) -> Result<DMatrix<f64>, InferError> {
        let (laws, own) = self.parted(model, values)?;
        let rows = self.base.len();
        let column = |&k: &usize| -> Result<Vec<f64>, InferError> {
            let Some(parameter) = k.checked_sub(laws.len()) else { return self.slope(model, values, k) };
            let place = self.free.iter().position(|&f| f == parameter);
            let Some(j) = place else { return Ok(vec![0.0; rows]) };
            let (at, value) = (self.values[parameter], own[parameter]);
            let slope = if self.is_positive(parameter) { at / value.max(f64::MIN_POSITIVE) } else { 1.0 };
            Ok(self.columns[j].iter().map(|c| slope * c).collect())
        };
        let columns = free.par_iter().map(column).collect::<Result<Vec<_>, InferError>>()?;
        Ok(DMatrix::from_fn(rows, free.len(), |i, j| columns[j][i]))
    }

    fn slope(&self, model: &Model, values: &[f64], k: usize) -> Result<Vec<f64>, InferError> {
        let slots = model.slots();
        let h = RELATIVE * scale(&slots[k], values[k]);
        let side = |sign: f64| -> Result<Vec<f64>, InferError> {
            let mut moved = values[..slots.len()].to_vec();
            moved[k] += sign * h;
            Ok(self.of_laws(&model.plant(&moved)?))
        };
        let (high, low) = (side(1.0)?, side(-1.0)?);
        Ok(high.iter().zip(&low).map(|(a, b)| (a - b) / (2.0 * h)).collect())
    }
}

/// Mass in one interval: a wrench `w` held over it changes the twist by `∫ e^(−K(T−s)) ds M⁻¹ w`, where the twist
/// before fades as `A = e^(−KT)`; the integral is `(I + A) T/2` to second order. `None` where that has no inverse, or on
/// a rail.
fn felt(interval: &Interval, map: &Map) -> Option<f64> {
    let fades: Matrix3<f64> = map.a.fixed_view::<3, 3>(3, 3).into_owned();
    let gains: Matrix3<f64> = map.b.fixed_view::<3, 3>(3, 0).into_owned();
    let held = (Matrix3::identity() + fades) * (interval.span / 2.0);
    let resists = (held.try_inverse()? * gains).try_inverse()?;
    // From the object's axes to the world's: two columns of m times a turn.
    let (sin, cos) = interval.middle.pose[2].sin_cos();
    let turned = resists * Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
    let mass = 0.5 * (turned[(0, 0)] + turned[(1, 1)]);
    (mass.is_finite() && mass > 0.0).then_some(mass)
}

fn scale(slot: &Slot, value: f64) -> f64 {
    use trundle_model::Prior;
    match slot.prior {
        Prior::LogNormal { median, .. } => value.abs().max(1e-3 * median),
        Prior::Normal { sd, .. } => sd,
        Prior::Angle(_) => 1.0,
        _ => slot.upper - slot.lower,
    }
}

impl Likelihood for Along {
    fn cost(&self, model: &Model, values: &[f64]) -> Result<f64, InferError> {
        let (laws, own) = self.parted(model, values)?;
        let innovations = self.innovations(&model.plant(laws)?, own);
        let normaliser: f64 = self.gains.iter().map(|g| g.normaliser).sum();
        let cost = normaliser + 0.5 * innovations.iter().map(|e| e * e).sum::<f64>();
        Ok(if cost.is_finite() { cost } else { f64::INFINITY })
    }

    fn linearise(&self, model: &Model, values: &[f64], free: &[usize]) -> Result<Linearised, InferError> {
        let (laws, own) = self.parted(model, values)?;
        let cost = self.cost(model, values)?;
        let innovations = DVector::from_vec(self.innovations(&model.plant(laws)?, own));
        let jacobian = self.jacobian(model, values, free)?;
        Ok(Linearised {
            cost,
            gradient: jacobian.tr_mul(&innovations),
            curvature: jacobian.tr_mul(&jacobian),
        })
    }

    fn channels(&self) -> Channels {
        self.channels
    }

    fn tuned(&self, _: &Model, _: &[f64]) -> Result<Option<Box<dyn Likelihood + '_>>, InferError> {
        Ok(None)
    }

    fn noise(&self) -> Vec<Slot> {
        self.parameters.clone()
    }

    fn coarse(&self) -> Option<&dyn Likelihood> {
        self.sketch.as_deref().map(|sketch| sketch as &dyn Likelihood)
    }

    fn split(&self) -> Vec<(String, Box<dyn Likelihood + '_>)> {
        let one = |k: usize| -> (String, Box<dyn Likelihood + '_>) {
            (self.paths[k].name.clone(), Box::new(self.only(|e| e == k)))
        };
        (0..self.paths.len()).map(one).collect()
    }
}
