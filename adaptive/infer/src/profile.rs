//! Profile likelihood of one parameter: the increase of the cost when the parameter is fixed and all others
//! are optimised (Bates & Watts 1988, section 6.1).
//!
//! ```text
//! D(φ) = 2 (min over the others of cost at φ − global minimum);   90 % of D under χ²₁ lie below 2.71
//! ```
//! The prior of the profiled parameter is left out; the priors of the others remain. A profile that does not
//! rise shows that the data do not determine the parameter, whatever the curvature at the mode.

use crate::levenberg;
use crate::optimum::Stop;
use crate::{Density, Fit, InferError, Linearised, Target, Watch};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use trundle_model::Prior;

/// 90 % quantile of χ² with one degree of freedom.
pub const CHI2_90: f64 = 2.705_543_454;

const STOP: Stop = Stop { iterations: 25, decrease: 1e-3, measure_gradient: false };

/// Prior standard deviations at which a profile ends.
const MAX_PRIOR_SD: f64 = 4.0;

/// Deviance at which one side of a profile ends.
const MAX_DEVIANCE: f64 = 3.0 * CHI2_90;

/// First step, in posterior standard deviations, and growth factor of the steps.
const FIRST_STRIDE_SD: f64 = 0.4;
const STRIDE_GROWTH: f64 = 1.15;

/// Maximum number of steps on each side.
const MAX_STEPS_PER_SIDE: usize = 24;

/// Random starts of the other parameters that search for further optima at a point.
const RANDOM_STARTS: usize = 3;

/// Shape of a profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// The profile rises on both sides.
    TwoSided,
    /// It rises only below: the data give a lower bound.
    AtLeast,
    /// It rises only above: the data give an upper bound.
    AtMost,
    /// It rises on neither side: the data give no bound.
    Flat,
}

/// Profile of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// Name of the parameter.
    pub name: String,
    /// SI unit.
    pub unit: &'static str,
    /// Values in ascending order.
    pub values: Vec<f64>,
    /// Deviance at each value.
    pub deviance: Vec<f64>,
    /// Ends of the 90 % interval; `None` for an end beyond four prior standard deviations.
    pub interval: [Option<f64>; 2],
    /// Shape of the profile.
    pub shape: Shape,
    /// Local optima within the deviance of the interval. More than one means that the estimate is ambiguous.
    pub modes: Vec<f64>,
}

/// Profile the coordinate `k` of `target` around a fit, at the values `grid` (SI units) or at automatically
/// chosen ones.
///
/// # Errors
/// When `k` is not a coordinate, or the user interrupts.
pub fn profile(
    target: &Target<'_>,
    fit: &Fit,
    k: usize,
    grid: Option<&[f64]>,
    watch: &dyn Watch,
) -> Result<Profile, InferError> {
    if k >= target.dimension() || fit.point.len() != target.dimension() {
        let free = fit.estimates.iter().map(|e| e.name.as_str()).collect::<Vec<_>>().join(", ");
        return Err(InferError::NotFree { name: format!("parameter {k}"), free });
    }
    let profiler = Profiler { target, k, watch };
    let mut points = match grid {
        Some(values) => profiler.at_values(fit, values)?,
        None => profiler.outwards(fit)?,
    };
    points.sort_by(|a, b| a.z.total_cmp(&b.z));
    profiler.search_other_optima(&mut points)?;
    Ok(summarise(target, k, &points))
}

/// A value of the parameter, with the optimal other parameters.
struct Point {
    z: f64,
    others: Vec<f64>,
    cost: f64,
}

struct Profiler<'a> {
    target: &'a Target<'a>,
    k: usize,
    watch: &'a dyn Watch,
}

impl Profiler<'_> {
    /// Optimum at `z`, searched from `others`.
    fn at(&self, z: f64, others: &[f64]) -> Result<Point, InferError> {
        let slice = Slice { target: self.target, k: self.k, z };
        let clamp = |j, value| self.target.clamp(slice.target_index(j), value);
        let found = levenberg::minimise(&slice, others.to_vec(), clamp, STOP, self.watch)?;
        Ok(Point { z, others: found.point, cost: found.at.cost - slice.own_prior() })
    }

    /// Profile from the mode outwards; each point starts from the previous one.
    fn outwards(&self, fit: &Fit) -> Result<Vec<Point>, InferError> {
        let sd = fit.spread[(self.k, self.k)].max(0.0).sqrt().clamp(1e-6, 1.0);
        let start = self.at(fit.point[self.k], &without(&fit.point, self.k))?;
        let mut points = vec![];
        for sign in [-1.0, 1.0] {
            let (mut others, mut z, mut stride) = (start.others.clone(), start.z, FIRST_STRIDE_SD * sd);
            for step in 0..MAX_STEPS_PER_SIDE {
                z += sign * stride;
                let end = self.range_end(z, start.z);
                let point = self.at(end.unwrap_or(z), &others)?;
                self.watch
                    .progress("profile", (step as f64 / MAX_STEPS_PER_SIDE as f64 + sign.max(0.0)) / 2.0);
                let done = end.is_some() || point.cost > start.cost + MAX_DEVIANCE / 2.0;
                others.clone_from(&point.others);
                points.push(point);
                if done {
                    break;
                }
                stride *= STRIDE_GROWTH;
            }
        }
        points.push(start);
        Ok(points)
    }

    /// End of the range if `z` lies beyond it: half a period, or the limit of the prior.
    fn range_end(&self, z: f64, mode: f64) -> Option<f64> {
        let (low, high) = match self.target.slot(self.k).prior {
            Prior::Angle(period) => (mode - period / 2.0, mode + period / 2.0),
            _ => (mode.min(0.0) - MAX_PRIOR_SD, mode.max(0.0) + MAX_PRIOR_SD),
        };
        (z <= low || z >= high).then(|| self.target.clamp(self.k, z.clamp(low, high)))
    }

    fn at_values(&self, fit: &Fit, values: &[f64]) -> Result<Vec<Point>, InferError> {
        let mut all = self.target.shared_values(&fit.point).0;
        let slot = self.target.coordinates().free()[self.target.parameter(self.k)];
        let mut points = vec![self.at(fit.point[self.k], &without(&fit.point, self.k))?];
        for &value in values {
            all[slot] = value;
            let z = self.target.point(&all)[self.k];
            let near = points.iter().min_by(|a, b| (a.z - z).abs().total_cmp(&(b.z - z).abs()));
            let others = near.map_or_else(|| without(&fit.point, self.k), |p| p.others.clone());
            points.push(self.at(z, &others)?);
        }
        Ok(points)
    }

    /// Searches for other optima at both ends and in the middle, and passes improvements to neighbouring
    /// points.
    fn search_other_optima(&self, points: &mut [Point]) -> Result<(), InferError> {
        let n = points.len();
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        for at in [0, n / 2, n - 1] {
            for _ in 0..RANDOM_STARTS {
                let drawn = without(&self.target.draw(&mut rng), self.k);
                self.improve(&mut points[at], &drawn)?;
            }
        }
        for (from, to) in (1..n).map(|i| (i - 1, i)).chain((1..n).rev().map(|i| (i, i - 1))) {
            let others = points[from].others.clone();
            self.improve(&mut points[to], &others)?;
        }
        Ok(())
    }

    /// Replaces a point if the search from `others` finds a lower cost.
    fn improve(&self, point: &mut Point, others: &[f64]) -> Result<(), InferError> {
        let slice = Slice { target: self.target, k: self.k, z: point.z };
        if slice.cost(others)?.is_finite() {
            let found = self.at(point.z, others)?;
            if found.cost < point.cost - STOP.decrease {
                *point = found;
            }
        }
        Ok(())
    }
}

/// The density with one coordinate fixed.
struct Slice<'a> {
    target: &'a Target<'a>,
    k: usize,
    z: f64,
}

impl Slice<'_> {
    /// Index in the target of the `j`-th coordinate of the slice.
    fn target_index(&self, j: usize) -> usize {
        if j < self.k { j } else { j + 1 }
    }

    fn full_point(&self, others: &[f64]) -> Vec<f64> {
        let mut z = others.to_vec();
        z.insert(self.k, self.z);
        z
    }

    /// Contribution of the prior of the fixed coordinate to the cost.
    fn own_prior(&self) -> f64 {
        self.target.coordinates().prior_cost_of(self.target.parameter(self.k), self.z)
    }
}

impl Density for Slice<'_> {
    fn dimension(&self) -> usize {
        self.target.dimension() - 1
    }

    fn cost(&self, others: &[f64]) -> Result<f64, InferError> {
        self.target.cost(&self.full_point(others))
    }

    fn linearise(&self, others: &[f64]) -> Result<Linearised, InferError> {
        let at = self.target.linearise(&self.full_point(others))?;
        Ok(Linearised {
            cost: at.cost,
            gradient: at.gradient.remove_row(self.k),
            curvature: at.curvature.remove_row(self.k).remove_column(self.k),
        })
    }
}

fn without(z: &[f64], k: usize) -> Vec<f64> {
    z.iter().enumerate().filter(|(j, _)| *j != k).map(|(_, z)| *z).collect()
}

/// Interval, shape and modes of a profile.
fn summarise(target: &Target<'_>, k: usize, points: &[Point]) -> Profile {
    let slot = target.slot(k);
    let least = points.iter().map(|p| p.cost).fold(f64::INFINITY, f64::min);
    let deviance: Vec<f64> = points.iter().map(|p| 2.0 * (p.cost - least)).collect();
    let values: Vec<f64> = points.iter().map(|p| target.value(k, p.z).0).collect();
    let z: Vec<f64> = points.iter().map(|p| p.z).collect();
    let inside: Vec<usize> = (0..z.len()).filter(|&i| deviance[i] <= CHI2_90).collect();
    let (first, last) = (inside.first().copied().unwrap_or(0), inside.last().copied().unwrap_or(0));
    let end = |inner: usize, outer: Option<usize>| {
        let outer = outer.filter(|&o| o < z.len())?;
        Some(target.value(k, crossing((z[inner], deviance[inner]), (z[outer], deviance[outer]))).0)
    };
    let interval = [end(first, first.checked_sub(1)), end(last, Some(last + 1))];
    let shape = match interval {
        [Some(_), Some(_)] => Shape::TwoSided,
        [Some(_), None] => Shape::AtLeast,
        [None, Some(_)] => Shape::AtMost,
        [None, None] => Shape::Flat,
    };
    let modes = modes(&deviance).into_iter().map(|i| values[i]).collect();
    Profile { name: slot.name, unit: slot.unit, values, deviance, interval, shape, modes }
}

/// Point at which the deviance crosses the quantile, by linear interpolation of its square root.
fn crossing((z0, d0): (f64, f64), (z1, d1): (f64, f64)) -> f64 {
    let root = |d: f64| d.max(0.0).sqrt();
    let share = (root(CHI2_90) - root(d0)) / (root(d1) - root(d0)).max(1e-12);
    z0 + share.clamp(0.0, 1.0) * (z1 - z0)
}

/// Local optima within the deviance of the interval, separated by a rise of at least one.
fn modes(deviance: &[f64]) -> Vec<usize> {
    const MIN_RIDGE: f64 = 1.0;
    let mut modes: Vec<usize> = vec![];
    let mut ridge = 0.0_f64;
    for (i, &d) in deviance.iter().enumerate() {
        ridge = ridge.max(d);
        match modes.last().copied() {
            _ if d > CHI2_90 => {}
            Some(last) if ridge < d.max(deviance[last]) + MIN_RIDGE => {
                if d < deviance[last] {
                    modes.pop();
                    modes.push(i);
                    ridge = d;
                }
            }
            _ => {
                modes.push(i);
                ridge = d;
            }
        }
    }
    modes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shallow_ripple_does_not_add_a_mode() {
        assert_eq!(modes(&[4.0, 1.0, 0.0, 2.0, 1.2, 0.5, 5.0]), vec![2, 5]);
        assert_eq!(modes(&[4.0, 1.0, 0.0, 0.6, 0.4, 2.0, 5.0]), vec![2]);
        assert_eq!(modes(&[0.0; 5]), vec![0]);
    }

    #[test]
    fn the_crossing_of_a_parabola_is_exact() {
        assert!((crossing((1.0, 1.0), (2.0, 4.0)) - CHI2_90.sqrt()).abs() < 1e-12);
    }
}
