//! The profile of one parameter: how much worse the data can be explained when it is held elsewhere, all others
//! taking the values that suit best (Bates & Watts 1988, section 6.1).
//!
//! ```text
//! D(φ) = 2 (min over the others of cost at φ − the least of all);   90 % of D under χ²₁ lie below 2.71
//! ```
//! The parameter's own prior is left out, those of the others stay: a profile that does not rise says that the data
//! do not hold the parameter, whatever the curvature at the mode says.

use crate::levenberg::{self, Stop};
use crate::{Density, Fit, InferError, Linearised, Target, Watch};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use trundle_model::Prior;

/// Quantile of χ² with one degree of freedom at 90 %.
pub const NINETY: f64 = 2.705_543_454;

const STOP: Stop = Stop { iterations: 25, decrease: 1e-3, measure_gradient: false };

/// Prior standard deviations beyond which a profile is not followed.
const REACH: f64 = 4.0;

/// Deviance at which a walk has seen enough.
const ENOUGH: f64 = 3.0 * NINETY;

/// Steps of a walk, in posterior standard deviations: the first, and how they grow.
const STRIDE: (f64, f64) = (0.4, 1.15);

/// Steps to one side.
const STEPS: usize = 24;

/// Draws of the other parameters that look for another optimum where a walk has got.
const DRAWS: usize = 3;

/// What a profile looks like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// It rises to both sides.
    TwoSided,
    /// It rises only below: the data say "at least".
    AtLeast,
    /// It rises only above: the data say "at most".
    AtMost,
    /// It rises to neither side: the data say nothing.
    Flat,
}

/// A profile over a parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// The parameter.
    pub name: String,
    /// SI unit.
    pub unit: &'static str,
    /// Values, rising.
    pub values: Vec<f64>,
    /// Deviance at each.
    pub deviance: Vec<f64>,
    /// Ends of the 90 % interval; `None` where it does not end within four prior standard deviations.
    pub interval: [Option<f64>; 2],
    /// What it looks like.
    pub shape: Shape,
    /// Values of local optima within the interval's deviance: more than one is an ambiguity.
    pub modes: Vec<f64>,
}

/// Profile the coordinate `k` of `target` around a fit, at `grid` (values, SI), or where it is worth it.
///
/// # Errors
/// When `k` is no coordinate, or the user interrupts.
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
    let walker = Walker { target, k, watch };
    let mut points = match grid {
        Some(values) => walker.given(fit, values)?,
        None => walker.around(fit)?,
    };
    points.sort_by(|a, b| a.z.total_cmp(&b.z));
    walker.second_look(&mut points)?;
    Ok(read(target, k, &points))
}

/// One value of the parameter, with what suits it best.
struct Point {
    z: f64,
    others: Vec<f64>,
    cost: f64,
}

struct Walker<'a> {
    target: &'a Target<'a>,
    k: usize,
    watch: &'a dyn Watch,
}

impl Walker<'_> {
    /// The best point at `z`, searched from `others`.
    fn at(&self, z: f64, others: &[f64]) -> Result<Point, InferError> {
        let slice = Slice { target: self.target, k: self.k, z };
        let clamp = |j, value| self.target.clamp(slice.place(j), value);
        let found = levenberg::minimise(&slice, others.to_vec(), clamp, STOP, self.watch)?;
        Ok(Point { z, others: found.point, cost: found.at.cost - slice.own_prior() })
    }

    /// From the mode outwards, each point from the one before.
    fn around(&self, fit: &Fit) -> Result<Vec<Point>, InferError> {
        let sd = fit.spread[(self.k, self.k)].max(0.0).sqrt().clamp(1e-6, 1.0);
        let start = self.at(fit.point[self.k], &without(&fit.point, self.k))?;
        let mut points = vec![];
        for sign in [-1.0, 1.0] {
            let (mut others, mut z, mut stride) = (start.others.clone(), start.z, STRIDE.0 * sd);
            for step in 0..STEPS {
                z += sign * stride;
                let end = self.beyond(z, start.z);
                let point = self.at(end.unwrap_or(z), &others)?;
                self.watch.progress("profile", (step as f64 / STEPS as f64 + sign.max(0.0)) / 2.0);
                let done = end.is_some() || point.cost > start.cost + ENOUGH / 2.0;
                others.clone_from(&point.others);
                points.push(point);
                if done {
                    break;
                }
                stride *= STRIDE.1;
            }
        }
        points.push(start);
        Ok(points)
    }

    /// The end of the range, if `z` is beyond it: half a circle, or the prior's reach.
    fn beyond(&self, z: f64, mode: f64) -> Option<f64> {
        let (low, high) = match self.target.slot(self.k).prior {
            Prior::Angle(period) => (mode - period / 2.0, mode + period / 2.0),
            _ => (mode.min(0.0) - REACH, mode.max(0.0) + REACH),
        };
        (z <= low || z >= high).then(|| self.target.clamp(self.k, z.clamp(low, high)))
    }

    fn given(&self, fit: &Fit, values: &[f64]) -> Result<Vec<Point>, InferError> {
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

    /// Look for other optima at both ends and in the middle, and carry what is better to the neighbours.
    fn second_look(&self, points: &mut [Point]) -> Result<(), InferError> {
        let n = points.len();
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        for at in [0, n / 2, n - 1] {
            for _ in 0..DRAWS {
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

    /// Put a better optimum in a point's place, if there is one from `others`.
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

/// The density with one coordinate held.
struct Slice<'a> {
    target: &'a Target<'a>,
    k: usize,
    z: f64,
}

impl Slice<'_> {
    /// The target's coordinate that is the `j`-th here.
    fn place(&self, j: usize) -> usize {
        if j < self.k { j } else { j + 1 }
    }

    fn whole(&self, others: &[f64]) -> Vec<f64> {
        let mut z = others.to_vec();
        z.insert(self.k, self.z);
        z
    }

    /// What the prior of the held coordinate adds to the cost.
    fn own_prior(&self) -> f64 {
        self.target.coordinates().prior_cost_of(self.target.parameter(self.k), self.z)
    }
}

impl Density for Slice<'_> {
    fn dimension(&self) -> usize {
        self.target.dimension() - 1
    }

    fn cost(&self, others: &[f64]) -> Result<f64, InferError> {
        self.target.cost(&self.whole(others))
    }

    fn linearise(&self, others: &[f64]) -> Result<Linearised, InferError> {
        let at = self.target.linearise(&self.whole(others))?;
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

/// Interval, shape and modes of a profile's points.
fn read(target: &Target<'_>, k: usize, points: &[Point]) -> Profile {
    let slot = target.slot(k);
    let least = points.iter().map(|p| p.cost).fold(f64::INFINITY, f64::min);
    let deviance: Vec<f64> = points.iter().map(|p| 2.0 * (p.cost - least)).collect();
    let values: Vec<f64> = points.iter().map(|p| target.value(k, p.z).0).collect();
    let z: Vec<f64> = points.iter().map(|p| p.z).collect();
    let inside: Vec<usize> = (0..z.len()).filter(|&i| deviance[i] <= NINETY).collect();
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

/// Where the deviance crosses the quantile: its root is nearly linear.
fn crossing((z0, d0): (f64, f64), (z1, d1): (f64, f64)) -> f64 {
    let root = |d: f64| d.max(0.0).sqrt();
    let share = (root(NINETY) - root(d0)) / (root(d1) - root(d0)).max(1e-12);
    z0 + share.clamp(0.0, 1.0) * (z1 - z0)
}

/// Local optima within the interval's deviance, separated by a ridge of at least one.
fn modes(deviance: &[f64]) -> Vec<usize> {
    const RIDGE: f64 = 1.0;
    let mut modes: Vec<usize> = vec![];
    let mut ridge = 0.0_f64;
    for (i, &d) in deviance.iter().enumerate() {
        ridge = ridge.max(d);
        match modes.last().copied() {
            _ if d > NINETY => {}
            Some(last) if ridge < d.max(deviance[last]) + RIDGE => {
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
    fn two_valleys_are_two_modes_and_a_ripple_is_one() {
        assert_eq!(modes(&[4.0, 1.0, 0.0, 2.0, 1.2, 0.5, 5.0]), vec![2, 5]);
        assert_eq!(modes(&[4.0, 1.0, 0.0, 0.6, 0.4, 2.0, 5.0]), vec![2]);
        assert_eq!(modes(&[0.0; 5]), vec![0]);
    }

    #[test]
    fn a_parabola_is_crossed_where_it_crosses() {
        assert!((crossing((1.0, 1.0), (2.0, 4.0)) - NINETY.sqrt()).abs() < 1e-12);
    }
}
