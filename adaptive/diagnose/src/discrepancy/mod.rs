//! Model discrepancy (Kennedy & O'Hagan 2001): a wrench learnt from data if no known effect explains the
//! residual.
//!
//! The wrench is a function of measured quantities (motion, place, reading, time since contact), so that it can
//! predict other pushes. Its inputs are chosen by leave-one-episode-out validation. It is kept only if it also
//! improves simulations of episodes that it was not fitted to, one second ahead and over the whole episode. It
//! predicts but explains nothing.

mod fitter;
mod regression;
#[cfg(test)]
mod tests;
mod training_set;
mod validation;

use crate::lack_of_fit::LackOfFit;
use fitter::Fitter;
use rayon::prelude::*;
use regression::Regression;
use training_set::TrainingSet;
use trundle_infer::{Channels, Comparison, Fit, InferError, Watch, on_all_cores};
use trundle_model::{Axes, Input, Model};
use trundle_record::Dataset;
use validation::Validation;

/// Candidate inputs of the wrench, and the axes in which it is smooth.
const CANDIDATES: [(&[Input], Axes); 12] = [
    (&[Input::Twist], Axes::Object),
    (&[Input::Twist, Input::Heading], Axes::Object),
    (&[Input::Twist, Input::SinceContact], Axes::Object),
    (&[Input::Position], Axes::World),
    (&[Input::Position, Input::Heading], Axes::World),
    (&[Input::Position, Input::WorldTwist], Axes::World),
    (&[Input::SinceContact], Axes::World),
    (&[Input::Reading], Axes::Reading),
    (&[Input::Reading, Input::SinceContact], Axes::Reading),
    (&[Input::Trend], Axes::Reading),
    (&[Input::Trend, Input::SinceContact], Axes::Reading),
    (&[Input::Reading, Input::Trend], Axes::Reading),
];

/// Length scales that are tried, in standard deviations of the inputs. The first decides whether the others are
/// tried.
const WIDTHS: [f64; 3] = [1.4, 0.7, 2.8];
/// Length scales for a single input, whose data suffice for a force that oscillates.
const SINGLE_INPUT_WIDTHS: [f64; 3] = [1.4, 0.3, 0.1];
/// Relative χ² of left-out episodes above which no further length scales are tried.
const MAX_RELATIVE_CHI_SQUARE: f64 = 1.05;
/// Share of the missing wrench's random walk that remains next to the discrepancy, which takes most of it.
const REMAINING_WANDER: f64 = 0.03;
/// Number of candidates that are validated by simulation.
const MAX_VALIDATED: usize = 3;
/// Mean square error, relative to the best candidate, up to which the candidate with the fewest inputs is chosen.
const MAX_ERROR_OVER_BEST: f64 = 1.25;
/// Minimum number of training episodes for leave-one-out validation.
const MIN_EPISODES: usize = 3;

/// Fits the discrepancy wrench that predicts best and adds it to the nominal model; `None` if none passes the
/// validation.
///
/// # Errors
/// If the fit's values do not suit its model, or if the user interrupts.
pub(crate) fn fit_discrepancy(
    (data, nominal): (&Dataset, &Model),
    comparison: &Comparison,
    fit: &Fit,
    left: Option<LackOfFit>,
    watch: &dyn Watch,
) -> Result<Option<Fit>, InferError> {
    let (Comparison::Motion(motion), Some(left)) = (comparison, left) else { return Ok(None) };
    if fit.model.discrepancy.is_some() || data.training.len() < MIN_EPISODES {
        return Ok(None);
    }
    let wander = left.channels.wander.map(|w| REMAINING_WANDER * w);
    let wandering = motion.with_channels(Channels { wander, ..left.channels });
    let Some(training) = TrainingSet::new(&wandering, fit)? else { return Ok(None) };
    on_all_cores(watch, |watch| {
        let fitter = Fitter { data, nominal, motion: &wandering, fit, watch };
        let validation = Validation::new(&fitter)?;
        let Some(best) = simplest(&training, &validation)? else { return Ok(None) };
        let rounds = validation.rounds(&best)?;
        rounds.map(|rounds| fitter.fit(None, &best, rounds)).transpose().map(Option::flatten)
    })
}

/// The candidate with the fewest inputs among those whose validation error is close to the smallest.
fn simplest(
    training: &TrainingSet,
    validation: &Validation<'_, '_>,
) -> Result<Option<Regression>, InferError> {
    let best = |&(inputs, axes): &(&[Input], Axes)| best_width(training, inputs, axes);
    let mut regressions: Vec<Regression> = CANDIDATES.par_iter().filter_map(best).collect();
    regressions.sort_by(|a, b| a.relative_chi_square.total_cmp(&b.relative_chi_square));
    let mut validated: Vec<(f64, Regression)> = vec![];
    for regression in regressions.into_iter().filter(|r| r.relative_chi_square < 1.0).take(MAX_VALIDATED) {
        validated.extend(validation.relative_error(&regression)?.map(|error| (error, regression)));
    }
    let smallest = validated.iter().map(|(error, _)| *error).fold(f64::INFINITY, f64::min);
    let close = validated.into_iter().filter(|(error, _)| *error <= MAX_ERROR_OVER_BEST * smallest);
    let simplest = close.min_by(|a, b| a.1.input_count().cmp(&b.1.input_count()).then(a.0.total_cmp(&b.0)));
    Ok(simplest.map(|(_, regression)| regression))
}

/// Descriptions of the inputs of a model's discrepancy wrench, for the report.
pub(crate) fn input_descriptions(fit: &Fit) -> Vec<&'static str> {
    fit.model
        .discrepancy
        .iter()
        .flat_map(|unnamed| &unnamed.inputs)
        .map(|input| input.description())
        .collect()
}

/// The regression whose length scales predict left-out episodes best.
fn best_width(training: &TrainingSet, inputs: &[Input], axes: Axes) -> Option<Regression> {
    let is_single = inputs.iter().map(|input| input.width()).sum::<usize>() == 1;
    let mut best: Option<Regression> = None;
    for width in if is_single { SINGLE_INPUT_WIDTHS } else { WIDTHS } {
        let regression = Regression::new(training, training.unweighted(inputs, axes, width))?;
        let is_poor = regression.relative_chi_square > MAX_RELATIVE_CHI_SQUARE && !is_single;
        if best.as_ref().is_none_or(|best| regression.relative_chi_square < best.relative_chi_square) {
            best = Some(regression);
        }
        if is_poor {
            break;
        }
    }
    best
}
