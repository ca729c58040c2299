//! A wrench without a name, where nothing known explains what is missing: it predicts, and explains nothing.
//!
//! It is a function of what is seen (the motion, the place, the reading, the time since contact), so that it can
//! predict other pushes; what it depends on is chosen by leaving one training episode out at a time. It is kept only
//! where it also foresees, simulated, the motion of episodes that it was not fitted to, one second ahead and to the end.

mod course;
mod proof;
mod regression;
#[cfg(test)]
mod tests;

use crate::adequacy::Remainder;
use course::Course;
use proof::Proof;
use rayon::prelude::*;
use regression::Regression;
use std::sync::Arc;
use trundle_infer::{
    Channels, Comparison, Fit, FitOptions, InferError, MotionLikelihood, Watch, fit, on_all_cores,
};
use trundle_model::{Axes, Input, Model, Unnamed};
use trundle_record::Dataset;

/// What a wrench may depend on, and the axes in which it is smooth then.
const CHOICES: [(&[Input], Axes); 12] = [
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

/// Lengths over which it changes, in standard deviations of what was seen; the first decides whether others are tried.
const WIDTHS: [f64; 3] = [1.4, 0.7, 2.8];
/// The same where it depends on one number: there is enough to see of that for a force that swings.
const FINE: [f64; 3] = [1.4, 0.3, 0.1];
/// χ² of episodes left out, over that without an unnamed wrench, beyond which other widths are not tried.
const HOPELESS: f64 = 1.05;
/// How much of the missing wrench's walk is left to wander beside it: less than all, since it takes most of it away.
const WANDERS: f64 = 0.03;
/// Choices that are simulated.
const SIMULATED: usize = 3;
/// Of those that err hardly more than the best, by so much in the mean square, the one that depends on least is taken.
const CLOSE: f64 = 1.25;
/// Training episodes without which there is nothing to leave out.
const FEWEST: usize = 3;

/// Steps of a fit of the parameters beside it, at most.
const STEPS: usize = 60;

/// The simulation under test with the unnamed wrench that predicts best; `None` where none proves itself.
///
/// # Errors
/// When the fit's values do not suit its model, or the user interrupts.
pub(crate) fn unnamed(
    (data, nominal): (&Dataset, &Model),
    comparison: &Comparison,
    fit: &Fit,
    left: Option<Remainder>,
    watch: &dyn Watch,
) -> Result<Option<Fit>, InferError> {
    let (Comparison::Motion(motion), Some(left)) = (comparison, left) else { return Ok(None) };
    if fit.model.unnamed.is_some() || data.training.len() < FEWEST {
        return Ok(None);
    }
    let wander = left.channels.wander.map(|w| WANDERS * w);
    let wandering = motion.with_channels(Channels { wander, ..left.channels });
    let Some(course) = Course::new(&wandering, fit)? else { return Ok(None) };
    on_all_cores(watch, |watch| {
        let bench = Bench { data, nominal, motion: &wandering, fit, watch };
        let proof = Proof::new(&bench)?;
        let Some(best) = simplest(&course, &proof)? else { return Ok(None) };
        let rounds = proof.rounds(&best)?;
        rounds.map(|rounds| bench.settled(None, &best, rounds)).transpose().map(Option::flatten)
    })
}

/// What an unnamed wrench is fitted with.
struct Bench<'a> {
    data: &'a Dataset,
    /// The simulation under test, its parameters free.
    nominal: &'a Model,
    /// Under noise that lets what the wrench leaves wander.
    motion: &'a MotionLikelihood,
    /// The simulation under test as fitted.
    fit: &'a Fit,
    watch: &'a dyn Watch,
}

impl Bench<'_> {
    /// Wrench and parameters fitted in turn, `rounds` times after the wrench alone, to all training episodes or all but
    /// one. The parameters had bent to what the wrench now says.
    fn settled(
        &self,
        without: Option<usize>,
        by: &Regression,
        rounds: usize,
    ) -> Result<Option<Fit>, InferError> {
        let motion = self.motion.only(|k| Some(k) != without);
        let Some(unnamed) = by.unnamed(without) else { return Ok(None) };
        let mut best = with(self.fit, unnamed);
        for _ in 0..rounds {
            let mut bare = self.refitted(&motion, &best)?;
            bare.model.unnamed = None;
            let again = Course::new(&motion, &bare)?.and_then(|course| by.again(&course)?.unnamed(None));
            let Some(unnamed) = again else { break };
            best = with(&bare, unnamed);
        }
        Ok(Some(best))
    }

    /// The parameters fitted again beside the wrench that `from` has.
    fn refitted(&self, motion: &MotionLikelihood, from: &Fit) -> Result<Fit, InferError> {
        let model = Model { unnamed: from.model.unnamed.clone(), ..self.nominal.clone() };
        let options = FitOptions {
            starts: 0,
            distant_starts: false,
            local_steps: Some(STEPS),
            ..FitOptions::default()
        };
        fit(motion, &model, std::slice::from_ref(&from.values), &options, self.watch)
    }
}

/// Of the choices that predict episodes left out nearly as well as the best, the one that depends on least.
fn simplest(course: &Course, proof: &Proof<'_, '_>) -> Result<Option<Regression>, InferError> {
    let sought = |&(inputs, axes): &(&[Input], Axes)| best_width(course, inputs, axes);
    let mut found: Vec<Regression> = CHOICES.par_iter().filter_map(sought).collect();
    found.sort_by(|a, b| a.left.total_cmp(&b.left));
    let mut proved: Vec<(f64, Regression)> = vec![];
    for regression in found.into_iter().filter(|r| r.left < 1.0).take(SIMULATED) {
        proved.extend(proof.share(&regression)?.map(|share| (share, regression)));
    }
    let least = proved.iter().map(|(share, _)| *share).fold(f64::INFINITY, f64::min);
    let close = proved.into_iter().filter(|(share, _)| *share <= CLOSE * least);
    let simplest = close.min_by(|a, b| a.1.numbers().cmp(&b.1.numbers()).then(a.0.total_cmp(&b.0)));
    Ok(simplest.map(|(_, regression)| regression))
}

/// What a model's unnamed wrench depends on, for the report.
pub(crate) fn depends_on(fit: &Fit) -> Vec<&'static str> {
    fit.model.unnamed.iter().flat_map(|unnamed| &unnamed.inputs).map(|input| input.words()).collect()
}

/// The regression whose width foresees episodes left out best.
fn best_width(course: &Course, inputs: &[Input], axes: Axes) -> Option<Regression> {
    let lone = inputs.iter().map(|input| input.width()).sum::<usize>() == 1;
    let mut best: Option<Regression> = None;
    for width in if lone { FINE } else { WIDTHS } {
        let found = Regression::new(course, course.blank(inputs, axes, width))?;
        let hopeless = found.left > HOPELESS && !lone;
        if best.as_ref().is_none_or(|best| found.left < best.left) {
            best = Some(found);
        }
        if hopeless {
            break;
        }
    }
    best
}

/// A fit whose model has an unnamed wrench as well.
fn with(fit: &Fit, unnamed: Unnamed) -> Fit {
    let mut fit = fit.clone();
    fit.model.unnamed = Some(Arc::new(unnamed));
    fit
}
