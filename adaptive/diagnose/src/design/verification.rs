//! Verification of a designed push with another simulator.

use super::experiment::{Experiment, PlannedPush, assemble};
use super::instructions::instructions;
use super::search::MIN_SEPARATION_NATS;
use super::setup::Setup;
use super::synthetic::{PosePredictor, resting_episode, scaled_to_limits, with_poses};
use trundle_infer::InferError;
use trundle_record::Prepared;

/// Verifies the first push of an experiment with a simulator in which two models predict the poses `predictors`.
///
/// The push is scaled down until it respects the limits there. `separations_of` returns the separations if the first
/// model is true and if the second is, nats. The result has no push if the separation is too small. `recorded`:
/// see [`Experiment::recorded`].
pub(crate) fn verify(
    experiment: &Experiment,
    setup: &Setup,
    predictors: [&PosePredictor<'_>; 2],
    separations_of: impl Fn(&[Prepared; 2]) -> Result<[f64; 2], InferError>,
    recorded: f64,
) -> Result<Experiment, InferError> {
    let none = || assemble(experiment.models.clone(), vec![], [0.0; 2], recorded);
    let Some(planned) = experiment.pushes.first() else { return Ok(none()) };
    let Some(push) = scaled_to_limits(&predictors, &planned.push, setup)? else { return Ok(none()) };
    let resting = resting_episode(&push, &setup.instruments, setup.recorded_episodes);
    let of = |k: usize| Ok::<_, InferError>(with_poses(resting.clone(), &predictors[k](&resting)?));
    let separations = separations_of(&[of(0)?, of(1)?])?;
    let separation = separations.iter().sum::<f64>() / 2.0;
    if separation.is_nan() || separation <= MIN_SEPARATION_NATS {
        return Ok(none());
    }
    let (knots, sentence) = (push.knots(), instructions(&push, setup));
    let planned = PlannedPush { push, knots, separation, cumulative: separation, sentence };
    Ok(assemble(experiment.models.clone(), vec![planned], separations, recorded))
}
