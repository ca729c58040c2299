//! The verdict, and the probability that the named law is the right one.

use crate::answer::Verdict;
use crate::engine::Engine;
use crate::fitted_model::FittedModel;
use crate::lack_of_fit::LackOfFit;
use crate::thresholds::{MAX_MISFIT_PER_SAMPLE_NATS, MAX_RESIDUAL_GAIN_SHARE, NEGLIGIBLE_SHARE};
use trundle_infer::InferError;

/// Probability that the named laws are the right ones and not similar ones, by what they leave. It is one half at the
/// largest lack of fit that is still named.
pub(crate) fn right_law_probability(
    observations: usize,
    before: Option<LackOfFit>,
    named: NamedModel,
) -> f64 {
    let most = before.zip(named.lack).map(|(before, _)| named.largest_misfit(before, observations));
    most.map_or(1.0, |most| half_at(most, named.lack))
}

/// Probability that an effect with this gain, nats, is more than a part of what the other laws leave. It is one half if
/// as much remains as the effect gains, which is the most at which it is still named.
pub(crate) fn own_effect_probability(gain: f64, lack: Option<LackOfFit>) -> f64 {
    half_at(gain, lack)
}

/// A probability that falls from one, at no misfit, to one half at a misfit of `most` nats.
fn half_at(most: f64, lack: Option<LackOfFit>) -> f64 {
    lack.map_or(1.0, |lack| 1.0 / (1.0 + (lack.misfit() / most).powi(2)))
}

/// A named model: its gain over the nominal model, nats, and its lack of fit.
#[derive(Clone, Copy)]
pub(crate) struct NamedModel {
    pub gained: f64,
    pub lack: Option<LackOfFit>,
}

impl NamedModel {
    /// Largest misfit that the model may leave, nats: a negligible share of what was missing, or some nats per sample.
    fn largest_misfit(self, before: LackOfFit, observations: usize) -> f64 {
        let left = self.lack.map_or(0.0, |lack| lack.misfit());
        let missing = before.misfit().max(self.gained + left);
        (MAX_MISFIT_PER_SAMPLE_NATS * observations as f64).max(NEGLIGIBLE_SHARE * missing)
    }
}

/// The verdict from the lack of fit of the nominal model, the named model, if any, and whether the selected
/// model's prediction errors are `material`.
///
/// What was missing is the named model's gain plus the gain of a random-walk wrench in addition to it. If the
/// recording does not state the noise, the fitted noise of the nominal model absorbs unmodelled effects, and
/// its own lack of fit is too small. If more remains than a named model may leave, the law is more probably another one
/// ([`right_law_probability`]), even if it predicts well.
fn verdict(
    observations: usize,
    before: Option<LackOfFit>,
    named: Option<NamedModel>,
    material: bool,
) -> Verdict {
    let is_significant = |r: Option<LackOfFit>| material && r.is_some_and(|r| r.is_significant(observations));
    let Some(named) = named else {
        return if is_significant(before) { Verdict::Unexplained } else { Verdict::Consistent };
    };
    let (Some(before), Some(after)) = (before, named.lack) else { return Verdict::Explained };
    let missing = before.gain.max(named.gained + after.gain);
    let is_large = is_significant(named.lack) && after.gain > MAX_RESIDUAL_GAIN_SHARE * missing;
    let is_other_law = after.misfit() > named.largest_misfit(before, observations);
    if is_large || is_other_law { Verdict::Unexplained } else { Verdict::Explained }
}

/// The verdict if `model` is selected, and its lack of fit. `base` is the nominal model, and `before` its lack of fit.
pub(crate) fn verdict_of(
    engine: &dyn Engine,
    before: Option<LackOfFit>,
    base: &FittedModel,
    model: &FittedModel,
) -> Result<(Verdict, Option<LackOfFit>), InferError> {
    let check_of = |fitted: &FittedModel| {
        if engine.is_quasi_static() { Ok(None) } else { engine.predictive_check(fitted).map(Some) }
    };
    let is_named = !model.added.is_empty();
    let lack = engine.lack_of_fit(model)?;
    let errors = check_of(model)?;
    let named = is_named.then_some(NamedModel { gained: base.fit.cost - model.fit.cost, lack });
    let found = verdict(engine.observations(), before, named, errors.is_none_or(|check| check.is_material()));
    let is_poor = match (errors, check_of(base)?) {
        (Some(errors), Some(nominal)) => errors.is_poor(&nominal),
        _ => false,
    };
    Ok((if found == Verdict::Explained && is_poor { Verdict::Unexplained } else { found }, lack))
}

#[cfg(test)]
mod tests {
    use super::{NamedModel, own_effect_probability, right_law_probability, verdict};
    use crate::answer::Verdict;
    use crate::lack_of_fit::LackOfFit;
    use trundle_infer::Channels;

    const SAMPLES: usize = 2000;

    fn lack_of(gain: f64, chi_squared_excess: f64) -> Option<LackOfFit> {
        let channels = Channels { pose: [1e-3; 3], reading: [0.4; 3], wander: [0.0; 3] };
        Some(LackOfFit { gain, channels, chi_squared_excess })
    }

    #[test]
    fn an_effect_that_gains_as_much_as_remains_is_half_as_probable() {
        let probability = |gain| own_effect_probability(gain, lack_of(50.0, 400.0));
        assert!((probability(400.0) - 0.5).abs() < 1e-12);
        assert!(probability(4000.0) > 0.99 && probability(200.0) < 0.25);
        assert!((own_effect_probability(10.0, None) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn named_effects_must_leave_a_small_residual() {
        let named = |gained, lack| Some(NamedModel { gained, lack });
        let judged = |lack| verdict(SAMPLES, lack_of(5e5, 5e5), named(4e5, lack), true);
        assert_eq!(judged(lack_of(200.0, 400.0)), Verdict::Explained);
        assert_eq!(judged(lack_of(3e4, 3e4)), Verdict::Unexplained, "a law like the missing one");
        assert_eq!(judged(lack_of(0.0, 1.5e5)), Verdict::Unexplained, "impacts, for which no walk helps");
        let predicts_well = verdict(SAMPLES, lack_of(5e5, 5e5), named(4e5, lack_of(200.0, 3e4)), false);
        assert_eq!(predicts_well, Verdict::Unexplained, "a law that is more probably wrong");
        // If much was missing, a hundredth of it may remain.
        let of_large_misfit = verdict(SAMPLES, lack_of(4e6, 4e6), named(3e6, lack_of(2e4, 2e4)), true);
        assert_eq!(of_large_misfit, Verdict::Explained);
        // If little was missing, most of it must be explained.
        let of_small_misfit =
            |gained| verdict(SAMPLES, lack_of(100.0, 100.0), named(gained, lack_of(40.0, 40.0)), true);
        assert_eq!(of_small_misfit(60.0), Verdict::Unexplained);
        assert_eq!(
            of_small_misfit(1000.0),
            Verdict::Explained,
            "fitted noise had absorbed the missing effect"
        );
    }

    #[test]
    fn without_a_named_effect_the_lack_of_fit_decides() {
        assert_eq!(verdict(SAMPLES, lack_of(3.0, 300.0), None, true), Verdict::Consistent);
        assert_eq!(verdict(SAMPLES, lack_of(300.0, 300.0), None, true), Verdict::Unexplained);
        let immaterial = verdict(SAMPLES, lack_of(300.0, 300.0), None, false);
        assert_eq!(immaterial, Verdict::Consistent);
    }

    #[test]
    fn a_larger_lack_of_fit_makes_a_law_less_probable() {
        let probability =
            |gained, lack| right_law_probability(SAMPLES, lack_of(100.0, 100.0), NamedModel { gained, lack });
        assert!(probability(1e4, lack_of(0.0, 100.0)) > 0.99);
        assert!((probability(1e4, lack_of(4000.0, 0.0)) - 0.5).abs() < 1e-12);
        assert_eq!(probability(1e4, None), 1.0);
        // A thousandth of a large misfit is negligible.
        assert!(probability(4e6, lack_of(4000.0, 0.0)) > 0.98);
    }
}
