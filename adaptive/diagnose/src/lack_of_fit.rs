//! Lack-of-fit test: does a random-walk wrench in addition to a fitted model improve the likelihood?
//!
//! The test adds a random walk of the missing wrench to the filter. If the model is complete, the best size
//! of the walk is zero and the likelihood does not improve. The gain in log likelihood is the test statistic,
//! and the best size measures the missing wrench. The walk is non-parametric and does not identify an effect.

use crate::thresholds::is_significant;
use trundle_infer::{Channels, Comparison, Fit, InferError, Likelihood, MotionLikelihood};

/// Result of the lack-of-fit test.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LackOfFit {
    /// Gain in log likelihood, nats.
    pub gain: f64,
    /// Noise with the walk at its best size.
    pub channels: Channels,
    /// Half of the χ² of the innovations in excess of its expectation, nats. It detects misfit that a random
    /// walk does not reduce, such as impacts.
    pub chi_squared_excess: f64,
}

/// Trial sizes of the walk, N/√s.
const WALK_SIZES: [f64; 12] = [1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0];

/// The lack of fit of a model; `None` if wrenches are compared instead of motion.
pub(crate) fn lack_of_fit(comparison: &Comparison, fit: &Fit) -> Result<Option<LackOfFit>, InferError> {
    match comparison.with_channels(fit.channels) {
        Comparison::Motion(motion) => motion_lack_of_fit(&motion, fit).map(Some),
        _ => Ok(None),
    }
}

/// The lack of fit of a model to motion, under the noise of `motion`.
pub(crate) fn motion_lack_of_fit(motion: &MotionLikelihood, fit: &Fit) -> Result<LackOfFit, InferError> {
    let cost = |channels: Channels| motion.with_channels(channels).cost(&fit.model, &fit.values);
    best_random_walk(motion.channels(), fit.model.body.gyration, chi_squared_excess(motion, fit)?, cost)
}

/// The best size of the walk. `cost` returns the −log likelihood under noise with a walk. The moment's walk
/// is the force's times the radius of gyration.
pub(crate) fn best_random_walk(
    channels: Channels,
    gyration: f64,
    chi_squared_excess: f64,
    cost: impl Fn(Channels) -> Result<f64, InferError>,
) -> Result<LackOfFit, InferError> {
    let with_walk = |size: f64| Channels { wander: [size, size, size * gyration], ..channels };
    let without_walk = cost(channels)?;
    let mut best = LackOfFit { gain: 0.0, channels: with_walk(WALK_SIZES[0]), chi_squared_excess };
    for size in WALK_SIZES {
        let channels = with_walk(size);
        let gain = without_walk - cost(channels)?;
        if gain > best.gain {
            best = LackOfFit { gain, channels, ..best };
        } else if best.gain > 0.0 && gain < best.gain - 50.0 {
            break;
        }
    }
    Ok(best)
}

impl LackOfFit {
    /// The larger of both measures of misfit, nats; near zero for the right model.
    pub fn misfit(&self) -> f64 {
        self.gain.max(self.chi_squared_excess)
    }

    /// Whether an effect is missing.
    pub fn is_significant(&self, observations: usize) -> bool {
        is_significant(self.gain, observations)
    }
}

/// Half of the χ² of the whitened innovations in excess of one per direction, nats.
pub(crate) fn chi_squared_excess(motion: &MotionLikelihood, fit: &Fit) -> Result<f64, InferError> {
    let (sum, directions) = motion.chi_squared(&fit.model, &fit.values)?;
    Ok((0.5 * (sum - directions as f64)).max(0.0))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::{WALK_SIZES, best_random_walk};
    use trundle_infer::{Channels, InferError};

    #[test]
    fn a_small_walk_that_makes_a_poor_fit_worse_does_not_end_the_search() {
        let channels = Channels { pose: [1e-3; 3], reading: [0.1; 3], wander: [0.0; 3] };
        let cost = |channels: Channels| -> Result<f64, InferError> {
            Ok(match channels.wander[0] {
                0.0 => 4e6,
                size if size < 0.02 => 4.1e6,
                size => 1e4 / size,
            })
        };
        let lack = best_random_walk(channels, 0.5, 0.0, cost).unwrap();
        let largest = WALK_SIZES[WALK_SIZES.len() - 1];
        assert!((lack.gain - (4e6 - 1e4 / largest)).abs() < 1.0, "{lack:?}");
    }
}
