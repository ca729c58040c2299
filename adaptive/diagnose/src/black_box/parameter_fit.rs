//! Fit of a black-box simulator's parameters: Gauss–Newton steps on its first-order expansion, each checked with
//! the simulator itself.

use super::likelihood::PathLikelihood;
use super::path::Path;
use super::simulator::BlackBox;
use trundle_infer::{Channels, Coordinates, FitOptions, InferError, Watch, fit};
use trundle_model::Model;

/// Maximum number of Gauss–Newton steps.
const MAX_STEPS: usize = 12;
/// Maximum number of halvings of a step.
const MAX_STEP_HALVINGS: u32 = 4;
/// Gain of a step below which the fit has converged, nats.
const MIN_GAIN_NATS: f64 = 0.05;

/// Linearises the simulator at the most probable values of its parameters, starting from `start`.
///
/// If `channels` include a random-walk wrench, missing effects do not bias the values.
pub(crate) fn fit_simulator(
    simulator: &BlackBox<'_>,
    paths: &[Path],
    start: &[f64],
    channels: Channels,
    bare: &Model,
    seed: u64,
    watch: &dyn Watch,
) -> Result<PathLikelihood, InferError> {
    let coordinates = Coordinates::of(simulator.parameters.clone());
    let mut values = start.to_vec();
    for round in 0..MAX_STEPS {
        watch.progress("the simulation under test", round as f64 / MAX_STEPS as f64);
        let likelihood = PathLikelihood::new(simulator, &values, paths, channels, bare.dof, watch)?;
        if coordinates.free().is_empty() {
            return Ok(likelihood);
        }
        let cost_at = |values: &[f64]| -> Result<f64, InferError> {
            Ok(likelihood.exact_cost(simulator, values, watch)?
                + coordinates.prior_cost(&coordinates.point(values)))
        };
        let current = cost_at(&values)?;
        let start: Vec<f64> = std::iter::once(bare.body.mass).chain(values.iter().copied()).collect();
        let options = FitOptions { starts: 0, seed, distant_starts: false, ..FitOptions::default() };
        let proposed = likelihood.parameter_values(&fit(&likelihood, bare, &[start], &options, watch)?);
        let (from, to) = (coordinates.point(&values), coordinates.point(&proposed));
        let mut improvement = None;
        for halving in 0..=MAX_STEP_HALVINGS {
            let share = 0.5f64.powi(halving as i32);
            let z: Vec<f64> = from.iter().zip(&to).map(|(a, b)| a + share * (b - a)).collect();
            let candidate = coordinates.values(&z).0;
            let cost = cost_at(&candidate)?;
            if cost < current {
                improvement = Some((candidate, current - cost));
                break;
            }
        }
        match improvement {
            Some((candidate, gain)) => {
                values = candidate;
                if gain < MIN_GAIN_NATS {
                    break;
                }
            }
            None => return Ok(likelihood),
        }
    }
    PathLikelihood::new(simulator, &values, paths, channels, bare.dof, watch)
}
