//! Readings of a resting object, as evidence about the offset of the wrench sensor.
//!
//! While the object rests and the reading is constant, either no wrench acts or an unknown static load acts.
//! With even odds, the corrected mean reading `r` has the density
//!
//! ```text
//! p(r) = ½ L N(r; 0, S) + ½ N(r; 0, S + F²)      S: variance of the mean, F: scale of the recorded wrenches
//! ```
//!
//! `L` is the likelihood ratio of two hypotheses about the readings: they vary by the sensor noise alone, or
//! by as much as observed. A varying load makes `L` small, so that such readings carry no information about
//! the offset.
//!
//! A sensor offset shifts all rest intervals alike, whereas a static load differs between them. An interval
//! counts once, whatever its duration, because all its readings share the same load.

use crate::InferError;
use crate::curve::Curve;
use crate::likelihood::Linearised;
use crate::steady_segments::{MIN_SEGMENT_S, SEGMENT_EDGE_S, between, is_moving};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;
use std::sync::Arc;
use trundle_model::{Clock, Dual, Model, Plant, Real};
use trundle_record::{Motion, Noise, Prepared};

/// Parts of a rest interval whose means are compared.
const PARTS_PER_INTERVAL: usize = 5;
/// Maximum number of parameters differentiated together.
const MAX_DUALS: usize = 8;

/// An interval in which the object rests after contact.
#[derive(Clone, Debug)]
struct RestInterval {
    episode: usize,
    /// Mean reading, reading axes.
    reading: [f64; 3],
    /// Variance of the mean caused by sensor noise.
    variance: [f64; 3],
    /// Log likelihood ratio of noise alone to a varying load.
    log_noise_ratio: f64,
    clock: Clock,
}

/// Readings of all rest intervals of some episodes.
#[derive(Clone, Debug, Default)]
pub(crate) struct RestingReadings {
    intervals: Arc<[RestInterval]>,
    /// Scale of the recorded wrenches, N, N, N·m.
    load: [f64; 3],
}

impl RestingReadings {
    /// Finds the rest intervals of some episodes.
    pub fn new(episodes: &[Prepared], noise: &Noise) -> Self {
        let of = |(k, episode)| rest_intervals(k, episode, noise);
        let readings = || episodes.iter().flat_map(|e| &e.wrench).map(|w| w.reading);
        let count = readings().count().max(1) as f64;
        let load = [0, 1, 2].map(|k| (readings().map(|r| r[k] * r[k]).sum::<f64>() / count).sqrt());
        Self { intervals: episodes.iter().enumerate().flat_map(of).collect(), load }
    }

    /// The same with a subset of the episodes.
    pub fn only(&self, keep: impl Fn(usize) -> bool) -> Self {
        Self {
            intervals: self.intervals.iter().filter(|rest| keep(rest.episode)).cloned().collect(),
            ..self.clone()
        }
    }

    /// Sum of −log density over all intervals.
    ///
    /// # Errors
    /// When `values` has the wrong length.
    pub fn cost(&self, model: &Model, values: &[f64]) -> Result<f64, InferError> {
        if self.intervals.is_empty() {
            return Ok(0.0);
        }
        let plant = model.plant(values)?;
        Ok(self.intervals.iter().map(|rest| self.cost_and_precision(rest, &rest.corrected(&plant)).0).sum())
    }

    /// The cost with its derivatives by the slots `free`. The curvature holds the odds of each interval
    /// fixed.
    pub fn linearise(&self, model: &Model, values: &[f64], free: &[usize]) -> Result<Linearised, InferError> {
        let mut parts = Linearised::sum(free.len(), []);
        if self.intervals.is_empty() {
            return Ok(parts);
        }
        let mut slopes = vec![DMatrix::zeros(3, free.len()); self.intervals.len()];
        for (chunk, slots) in free.chunks(MAX_DUALS).enumerate() {
            let mut lifted: Vec<Dual<MAX_DUALS>> = values.iter().map(|&v| Real::lift(v)).collect();
            for (k, &slot) in slots.iter().enumerate() {
                lifted[slot] = Dual::variable(values[slot], k);
            }
            let plant = model.plant(&lifted)?;
            for (rest, slopes) in self.intervals.iter().zip(&mut slopes) {
                for (k, corrected) in rest.corrected(&plant).iter().enumerate() {
                    for (j, slope) in corrected.eps[..slots.len()].iter().enumerate() {
                        slopes[(k, chunk * MAX_DUALS + j)] = *slope;
                    }
                }
            }
        }
        let plant = model.plant(values)?;
        for (rest, slopes) in self.intervals.iter().zip(&slopes) {
            let corrected = rest.corrected(&plant);
            let (cost, precision) = self.cost_and_precision(rest, &corrected);
            let force = DVector::from_fn(3, |k, _| precision[k] * corrected[k]);
            let weighted = DMatrix::from_fn(3, free.len(), |k, j| precision[k] * slopes[(k, j)]);
            parts.cost += cost;
            parts.gradient += slopes.tr_mul(&force);
            parts.curvature += slopes.tr_mul(&weighted);
        }
        Ok(parts)
    }

    /// −log density of an interval at its corrected reading, and the precision of each axis averaged over
    /// both hypotheses.
    fn cost_and_precision(&self, rest: &RestInterval, corrected: &[f64; 3]) -> (f64, [f64; 3]) {
        let loaded = [0, 1, 2].map(|k| rest.variance[k] + self.load[k] * self.load[k]);
        let log_density = |variance: &[f64; 3]| -> f64 {
            let axis = |k: usize| match variance[k] {
                v if v > 0.0 => -0.5 * (corrected[k] * corrected[k] / v + (TAU * v).ln()),
                _ => 0.0,
            };
            (0..3).map(axis).sum::<f64>() - 2.0_f64.ln()
        };
        let (free, held) = (log_density(&rest.variance) + rest.log_noise_ratio, log_density(&loaded));
        let top = free.max(held);
        let total = top + ((free - top).exp() + (held - top).exp()).ln();
        let share = (free - total).exp();
        let inverse = |v: f64| if v > 0.0 { v.recip() } else { 0.0 };
        let precision =
            [0, 1, 2].map(|k| share * inverse(rest.variance[k]) + (1.0 - share) * inverse(loaded[k]));
        (-total, precision)
    }
}

impl RestInterval {
    fn corrected<T: Real>(&self, plant: &Plant<T>) -> [T; 3] {
        plant.correct(self.reading.map(T::lift), self.clock)
    }
}

/// Rest intervals of one episode after contact.
fn rest_intervals(index: usize, episode: &Prepared, noise: &Noise) -> Vec<RestInterval> {
    let (motion, curve) = (episode.motion(noise), Curve::new(episode));
    let is_resting = |m: &Motion| m.t >= episode.contact && !is_moving(m);
    motion
        .chunk_by(|a, b| is_resting(a) == is_resting(b))
        .filter(|run| is_resting(&run[0]))
        .filter_map(|run| {
            let (start, end) = (run.first()?.t + SEGMENT_EDGE_S, run.last()?.t - SEGMENT_EDGE_S);
            (end - start >= MIN_SEGMENT_S)
                .then(|| rest_interval(index, episode, (noise, &curve), [start, end]))?
        })
        .collect()
}

fn rest_interval(
    index: usize,
    episode: &Prepared,
    (noise, curve): (&Noise, &Curve),
    [start, end]: [f64; 2],
) -> Option<RestInterval> {
    let readings = between(episode, start, end);
    if readings.len() < 2 * PARTS_PER_INTERVAL {
        return None;
    }
    let n = readings.len() as f64;
    let reading = [0, 1, 2].map(|k| readings.iter().map(|w| w.reading[k]).sum::<f64>() / n);
    let size = readings.len() / PARTS_PER_INTERVAL;
    let part = |k: usize| -> Vec<f64> {
        let mean =
            |p: &[trundle_record::WrenchSample]| p.iter().map(|w| w.reading[k]).sum::<f64>() / p.len() as f64;
        readings.chunks_exact(size).take(PARTS_PER_INTERVAL).map(mean).collect()
    };
    let sd = [noise.force, noise.force, noise.torque];
    let variance = [0, 1, 2].map(|k| sd[k] * sd[k] / n + episode.tare_sd[k].powi(2));
    let log_ratio = |k: usize| {
        let own: f64 = part(k).iter().map(|mean| (mean - reading[k]).powi(2)).sum();
        let ratio = own / (sd[k] * sd[k] / size as f64) / PARTS_PER_INTERVAL as f64;
        // Maximum-likelihood variance of the part means, at least that of the noise.
        if ratio > 1.0 { -0.5 * PARTS_PER_INTERVAL as f64 * (ratio - 1.0 - ratio.ln()) } else { 0.0 }
    };
    let log_noise_ratio = (0..3).map(log_ratio).sum();
    let t = (start + end) / 2.0;
    Some(RestInterval {
        episode: index,
        reading,
        variance,
        log_noise_ratio,
        clock: curve.clock_at_grasp(t, curve.frame(t).0),
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};
    use trundle_model::{Body, Effect, Kind};
    use trundle_record::{PoseSample, WrenchSample};

    const NOISE: Noise =
        Noise { pose: [1e-4, 1e-4, 1e-3], force: 0.05, torque: 0.01, time: 0.0, stated: true };

    /// A push with 5 N for one second, then two seconds of rest under a constant load.
    fn pushed(ordinal: usize, load: f64) -> Prepared {
        let mut rng = ChaCha8Rng::seed_from_u64(ordinal as u64);
        let mut noise = || -> f64 { StandardNormal.sample(&mut rng) };
        let pose = |k: usize| {
            let t = k as f64 / 50.0;
            PoseSample { t, pose: [0.1 * t.min(1.0) + 1e-4 * noise(), 1e-4 * noise(), 1e-3 * noise()] }
        };
        let poses = (0..150).map(pose).collect();
        let reading = |k: usize| {
            let t = k as f64 / 100.0;
            let force = if t < 1.0 { 5.0 } else { load };
            let reading = [force + 0.05 * noise(), 0.05 * noise(), 0.01 * noise()];
            WrenchSample { t, reading, ..WrenchSample::default() }
        };
        Prepared {
            name: format!("episode_{ordinal:02}"),
            ordinal,
            pose: poses,
            wrench: (0..300).map(reading).collect(),
            at_rest: true,
            ..Prepared::default()
        }
    }

    fn offset() -> Model {
        let square = [[-0.2, -0.2], [0.2, -0.2], [0.2, 0.2], [-0.2, 0.2]];
        let body = Body::from_footprint(&square, 5.0).unwrap();
        Model::nominal(body, None, [true; 3]).with(Effect::free(Kind::ForceBias))
    }

    fn cost(rests: &RestingReadings, force: f64) -> f64 {
        let model = offset();
        let mut values = vec![0.0; model.slots().len()];
        let at = model.slots().iter().position(|s| s.name == "force_bias.force_x").unwrap();
        values[0] = 5.0;
        values[at] = force;
        rests.cost(&model, &values).unwrap()
    }

    #[test]
    fn unloaded_readings_exclude_an_offset() {
        let rests = RestingReadings::new(&[pushed(0, 0.0), pushed(1, 0.0)], &NOISE);
        assert_eq!(rests.intervals.len(), 2);
        assert!(cost(&rests, 0.17) > cost(&rests, 0.0) + 5.0);
    }

    #[test]
    fn an_offset_affects_all_rest_intervals_and_a_static_load_one() {
        let offset = RestingReadings::new(&[0, 1, 2, 3].map(|k| pushed(k, 2.0)), &NOISE);
        assert!(cost(&offset, 0.0) > cost(&offset, 2.0) + 5.0);
        let loads =
            RestingReadings::new(&[pushed(0, 2.0), pushed(1, 0.0), pushed(2, 0.0), pushed(3, -1.3)], &NOISE);
        assert!(cost(&loads, 0.0) + 5.0 < cost(&loads, 2.0));
    }

    #[test]
    fn a_varying_load_has_no_information_about_the_offset() {
        let mut episode = pushed(0, 0.0);
        episode.wrench.iter_mut().for_each(|w| w.reading[0] += 0.5 * (4.0 * w.t).sin());
        let rests = RestingReadings::new(&[episode], &NOISE);
        let mean = rests.intervals[0].reading[0];
        assert!((cost(&rests, 0.0) - cost(&rests, mean)).abs() < 0.1);
    }

    #[test]
    fn gradient_matches_finite_differences() {
        let rests = RestingReadings::new(&[pushed(0, 0.3), pushed(1, 0.0)], &NOISE);
        let model = offset();
        let mut values = vec![0.1; model.slots().len()];
        values[0] = 5.0;
        let free: Vec<usize> = (0..values.len()).collect();
        let found = rests.linearise(&model, &values, &free).unwrap();
        let at = |values: &[f64]| rests.cost(&model, values).unwrap();
        assert!((found.cost - at(&values)).abs() < 1e-9);
        for k in free {
            let mut moved = values.clone();
            moved[k] += 1e-6;
            let up = at(&moved);
            moved[k] -= 2e-6;
            let slope = (up - at(&moved)) / 2e-6;
            assert!((found.gradient[k] - slope).abs() < 1e-3 * (1.0 + slope.abs()), "{k}: {slope}");
        }
    }
}
