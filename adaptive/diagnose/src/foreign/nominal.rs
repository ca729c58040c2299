//! The foreign simulation under test, fitted: Gauss–Newton on what it is to first order, each step held against the
//! simulator itself.

use super::likelihood::Along;
use super::path::Path;
use super::simulator::Foreign;
use trundle_infer::{Channels, Coordinates, FitOptions, InferError, Watch, fit};
use trundle_model::Model;

/// Rounds at most.
const ROUNDS: usize = 12;
/// A step is halved at most so often.
const HALVINGS: u32 = 4;
/// Gain of a round below which the search is at rest, nats.
const REST: f64 = 0.05;

/// The simulator linearised at the most probable values of its parameters, sought from `start`.
///
/// Under channels in which a missing wrench may wander, values do not bend to what the simulator lacks.
pub(crate) fn settle(
    foreign: &Foreign<'_>,
    paths: &[Path],
    start: &[f64],
    channels: Channels,
    bare: &Model,
    seed: u64,
    watch: &dyn Watch,
) -> Result<Along, InferError> {
    let coordinates = Coordinates::of(foreign.parameters.clone());
    let mut values = start.to_vec();
    for round in 0..ROUNDS {
        watch.progress("the simulation under test", round as f64 / ROUNDS as f64);
        let along = Along::new(foreign, &values, paths, channels, bare.dof, watch)?;
        if coordinates.free().is_empty() {
            return Ok(along);
        }
        let density = |values: &[f64]| -> Result<f64, InferError> {
            Ok(along.exactly(foreign, values, watch)? + coordinates.prior_cost(&coordinates.point(values)))
        };
        let now = density(&values)?;
        let start: Vec<f64> = std::iter::once(bare.body.mass).chain(values.iter().copied()).collect();
        let options = FitOptions { starts: 0, seed, distant_starts: false, ..FitOptions::default() };
        let proposed = along.own(&fit(&along, bare, &[start], &options, watch)?);
        let (here, there) = (coordinates.point(&values), coordinates.point(&proposed));
        let mut better = None;
        for halving in 0..=HALVINGS {
            let share = 0.5f64.powi(halving as i32);
            let z: Vec<f64> = here.iter().zip(&there).map(|(a, b)| a + share * (b - a)).collect();
            let candidate = coordinates.values(&z).0;
            let cost = density(&candidate)?;
            if cost < now {
                better = Some((candidate, now - cost));
                break;
            }
        }
        match better {
            Some((candidate, gain)) => {
                values = candidate;
                if gain < REST {
                    break;
                }
            }
            None => return Ok(along),
        }
    }
    Along::new(foreign, &values, paths, channels, bare.dof, watch)
}
