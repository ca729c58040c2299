//! Inputs and outputs of the regressions.

use super::predictor::StateVector;
use super::transitions::Transition;
use trundle_model::{to_body, to_world};

/// Maximum number of features.
pub(crate) const MAX_FEATURES: usize = 9;

/// Axes of the state and the wrench in a regression.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Features {
    /// State and wrench in world axes. This is the reading of the paper's `x_{t+1} = f(x_t, u_t)` under which
    /// an unconstrained object is linear, as the paper states for five of its objects.
    #[default]
    World,
    /// State in world axes and wrench in object axes, as recorded in eq. 7 and 13.
    Recorded,
    /// Twist and wrench in object axes, and the change in the axes of the object before. The prediction does
    /// not depend on the pose: a stronger baseline than the paper's, which has to learn this invariance.
    Body,
}

impl Features {
    /// All variants.
    pub const ALL: [Self; 3] = [Self::World, Self::Recorded, Self::Body];

    /// Index ranges of features with a common unit: positions, heading, velocity, spin, force, torque.
    pub(crate) fn groups(self) -> &'static [std::ops::Range<usize>] {
        match self {
            Self::World | Self::Recorded => &[0..2, 2..3, 3..5, 5..6, 6..8, 8..9],
            Self::Body => &[0..2, 2..3, 3..5, 5..6],
        }
    }

    /// Number of features.
    pub(crate) fn count(self) -> usize {
        if self == Self::Body { 6 } else { MAX_FEATURES }
    }

    /// The features of a state and a wrench.
    pub(crate) fn of(self, x: &StateVector, u: &[f64; 3]) -> Vec<f64> {
        let twist = [x[3], x[4], x[5]];
        match self {
            Self::World => x.iter().copied().chain(to_world(*u, x[2])).collect(),
            Self::Recorded => x.iter().chain(u).copied().collect(),
            Self::Body => to_body(twist, x[2]).into_iter().chain(*u).collect(),
        }
    }

    /// Mean rate of change over a transition, the target of a regression. For equal `dt` it is equivalent to
    /// `x'` as a target, since `x` is among the features. For unequal `dt` it is more accurate.
    pub(crate) fn rate(self, t: &Transition) -> StateVector {
        let change: StateVector = std::array::from_fn(|k| (t.after[k] - t.before[k]) / t.dt);
        let heading = t.before[2];
        self.turned(change, |v| to_body(v, heading))
    }

    /// State after a rate of change over `dt`.
    pub(crate) fn after(self, x: &StateVector, rate: StateVector, dt: f64) -> StateVector {
        let rate = self.turned(rate, |v| to_world(v, x[2]));
        std::array::from_fn(|k| x[k] + rate[k] * dt)
    }

    fn turned(self, [x, y, t, vx, vy, w]: StateVector, turn: impl Fn([f64; 3]) -> [f64; 3]) -> StateVector {
        match self {
            Self::World | Self::Recorded => [x, y, t, vx, vy, w],
            Self::Body => {
                let ([x, y, t], [vx, vy, w]) = (turn([x, y, t]), turn([vx, vy, w]));
                [x, y, t, vx, vy, w]
            }
        }
    }
}

/// Standardisation of the features to mean 0 and standard deviation 1 over the training data.
#[derive(Clone, Debug)]
pub(crate) struct Scale {
    mean: Vec<f64>,
    /// Inverse of the standard deviation; 0 for a constant feature.
    inverse: Vec<f64>,
}

impl Scale {
    pub(crate) fn of(rows: &[Vec<f64>], count: usize) -> Self {
        let n = rows.len().max(1) as f64;
        let mean: Vec<f64> = (0..count).map(|k| rows.iter().map(|r| r[k]).sum::<f64>() / n).collect();
        let sd = |k: usize| (rows.iter().map(|r| (r[k] - mean[k]).powi(2)).sum::<f64>() / n).sqrt();
        let inverse = (0..count).map(|k| if sd(k) > 1e-12 { 1.0 / sd(k) } else { 0.0 }).collect();
        Self { mean, inverse }
    }

    /// Standard deviation of each feature.
    pub(crate) fn sd(&self) -> impl Iterator<Item = f64> {
        self.inverse.iter().map(|i| if *i > 0.0 { 1.0 / i } else { 0.0 })
    }

    pub(crate) fn apply(&self, row: &[f64]) -> Vec<f64> {
        row.iter().zip(&self.mean).zip(&self.inverse).map(|((v, m), i)| (v - m) * i).collect()
    }
}
