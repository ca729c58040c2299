//! Whether a fitted model is enough: would the data rather have a wrench that wanders?
//!
//! A random walk of the missing wrench is added to the filter. Where nothing is missing its best
//! size is zero and nothing is gained; the gain in log likelihood is the test, its best size the
//! scale on which the missing wrench moves. The walk is non-parametric: it names nothing.

use crate::thresholds::is_significant;
use trundle_infer::{Channels, Comparison, Fit, InferError, Innovation, Likelihood, MotionLikelihood};

/// What a wandering wrench would gain.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LackOfFit {
    /// Gain in log likelihood.
    pub gain: f64,
    /// Noise with the walk at its best size.
    pub channels: Channels,
    /// Half of the χ² of the innovations beyond its expectation: what is left where no walk helps, like blows.
    pub chi_squared_excess: f64,
}

/// Sizes of the walk that are tried, N/√s.
const WALK_SIZES: [f64; 12] = [1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0];

/// The remainder that a fit leaves; `None` where only wrenches are compared.
pub(crate) fn lack_of_fit(comparison: &Comparison, fit: &Fit) -> Result<Option<LackOfFit>, InferError> {
    match comparison.with_channels(fit.channels) {
        Comparison::Motion(motion) => motion_lack_of_fit(&motion, fit).map(Some),
        _ => Ok(None),
    }
}

/// The same of motion, with the fit's channels.
pub(crate) fn motion_lack_of_fit(motion: &MotionLikelihood, fit: &Fit) -> Result<LackOfFit, InferError> {
    let cost = |channels: Channels| motion.with_channels(channels).cost(&fit.model, &fit.values);
    best_random_walk(motion.channels(), fit.model.body.gyration, chi_squared_excess(motion, fit)?, cost)
}

/// The best size of a walk, a moment wandering like the force at the radius of gyration; `cost` under noise with a walk.
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
        } else if gain < best.gain - 50.0 {
            break;
        }
    }
    Ok(best)
}

impl LackOfFit {
    /// All that a right model would not leave, nats.
    pub fn misfit(&self) -> f64 {
        self.gain.max(self.chi_squared_excess)
    }

    /// Whether something is missing.
    pub fn is_significant(&self, observations: usize) -> bool {
        is_significant(self.gain, observations)
    }
}

/// Half of the innovations' χ² beyond one of every direction.
fn chi_squared_excess(motion: &MotionLikelihood, fit: &Fit) -> Result<f64, InferError> {
    let Some(all) = motion.innovations(&fit.model, &fit.values)? else { return Ok(0.0) };
    let beyond = |i: &Innovation| {
        let directions = (0..3).filter(|&k| i.whitener[(k, k)] > 0.0).count();
        0.5 * ((i.whitener * i.error).norm_squared() - directions as f64)
    };
    Ok(all.iter().flatten().map(beyond).sum::<f64>().max(0.0))
}
