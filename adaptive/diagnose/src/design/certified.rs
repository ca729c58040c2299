//! A push that was designed with one simulation, as another sees it.

use super::bench::Bench;
use super::choose::LEAST;
use super::imagine::{Moves, commanded, moved, within_limits};
use super::sentence::spoken;
use super::{Experiment, Planned, told};
use trundle_infer::InferError;
use trundle_record::Prepared;

/// An experiment of one push as another simulation sees it, in which two models move an episode as `moves` say: the push made
/// weaker until it keeps within the limits there, with the separations that `apart` finds where the first model is true and
/// where the second is, nats. Without a push where it tells nothing there. `recorded`: see [`Experiment::recorded`].
pub(crate) fn certified(
    designed: &Experiment,
    bench: &Bench,
    moves: [&Moves<'_>; 2],
    apart: impl Fn(&[Prepared; 2]) -> Result<[f64; 2], InferError>,
    recorded: f64,
) -> Result<Experiment, InferError> {
    let none = || told(designed.models.clone(), vec![], [0.0; 2], recorded);
    let Some(planned) = designed.pushes.first() else { return Ok(none()) };
    let Some(push) = within_limits(&moves, &planned.push, bench)? else { return Ok(none()) };
    let still = commanded(&push, &bench.instruments, bench.recorded);
    let of = |k: usize| Ok::<_, InferError>(moved(still.clone(), &moves[k](&still)?));
    let separations = apart(&[of(0)?, of(1)?])?;
    let separation = separations.iter().sum::<f64>() / 2.0;
    if separation.is_nan() || separation <= LEAST {
        return Ok(none());
    }
    let (knots, sentence) = (push.knots(), spoken(&push, bench));
    let planned = Planned { push, knots, separation, cumulative: separation, sentence };
    Ok(told(designed.models.clone(), vec![planned], separations, recorded))
}
