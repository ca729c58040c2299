//! Which of the models that were tried is named, and what to say of it.

use crate::adequacy::Remainder;
use crate::answer::Verdict;
use crate::confirm::{Samples, correlation_time, holds_up};
use crate::cross_validation::{LeftOut, left_out};
use crate::engine::{Engine, Tried};
use crate::naming::{of_kinds, without};
use crate::search::Found;
use crate::thresholds::{LEFT_OVER, MATERIAL_RISE, NEGLIGIBLE_SHARE, SURE, UNSEEN};
use crate::whole::{ELSEWHERE, Whole};
use std::collections::BTreeMap;
use trundle_infer::{InferError, Watch, unscored_time};
use trundle_model::{Kind, Param};

/// Models whose effects are checked on left-out episodes, at most.
const MAX_CHECKED: usize = 24;

/// The model that is named, if any.
pub(crate) struct Choice {
    /// Index of the model in what was tried.
    pub best: usize,
    /// Of each of its effects, the chance that left-out episodes are predicted better with it.
    pub chances: Vec<f64>,
    /// How many models of more weight have an effect that did not earn its place.
    pub rejected: usize,
    /// Effects that are detectable and whose correction would not improve prediction by a material share: the model's index,
    /// the effect's in it, and its chance.
    pub immaterial: Vec<(usize, usize, f64)>,
    /// Why models that were tried are not named; models of less weight than the one that is named are not tested.
    pub reasons: BTreeMap<usize, &'static str>,
}

/// What a choice is made from.
pub(crate) struct Judge<'a> {
    pub engine: &'a dyn Engine,
    pub found: &'a Found,
    /// Index of the simulation under test in what was tried.
    pub base: usize,
    pub watch: &'a dyn Watch,
}

impl Judge<'_> {
    /// The model with the most weight each of whose effects is defined by the data, improves the predictive density of
    /// left-out training episodes by more than chance, and their prediction by a material share; without one, the
    /// simulation under test.
    pub fn choose(&self) -> Result<Choice, InferError> {
        let mut left_out = BTreeMap::new();
        let mut immaterial: Vec<(usize, usize, f64)> = vec![];
        let mut reasons = BTreeMap::new();
        let mut whole: Option<Whole<'_>> = None;
        let tried = &self.found.tried;
        let mut next = 0;
        while let Some(candidate) = tried.get(next) {
            let index = next;
            next += 1;
            if reasons.get(&index).is_some_and(|reason| *reason != ELSEWHERE) {
                continue;
            }
            if !whole.as_ref().is_none_or(|whole| whole.holds(candidate)) {
                reasons.insert(index, ELSEWHERE);
                continue;
            }
            let doubt = if left_out.len() >= MAX_CHECKED {
                Some("not tested: too many models before it")
            } else {
                self.doubtful(candidate)?
            };
            let chances = if doubt.is_some() { vec![] } else { self.chances(candidate, &mut left_out)? };
            let by_chance = chances.iter().any(|chance| *chance < SURE);
            if doubt.is_some() || by_chance {
                reasons.insert(
                    index,
                    doubt.unwrap_or("an effect does not improve the density of left-out episodes"),
                );
                // The other effects of the best model do not hold by themselves: other models may be the explanation.
                if let Some(void) = whole.take_if(|whole| whole.is_left(candidate)) {
                    next = void.index + 1;
                }
                continue;
            }
            let idle = self.idle(candidate, &mut left_out)?;
            if idle.is_empty() && self.has_simpler(candidate, &mut left_out)? {
                reasons.insert(index, "a simpler law predicts left-out episodes as well");
                continue;
            }
            if idle.is_empty() {
                return Ok(Choice { best: index, chances, rejected: index, immaterial, reasons });
            }
            reasons.insert(
                index,
                "an effect does not improve the prediction of left-out episodes by a material share",
            );
            for &k in &idle {
                let effect = candidate.names()[k];
                if immaterial.iter().all(|&(i, j, _)| tried[i].names()[j] != effect) {
                    immaterial.push((index, k, chances[k]));
                }
            }
            whole.get_or_insert(Whole { index, candidate, idle });
        }
        Ok(Choice { best: self.base, chances: vec![], rejected: 0, immaterial, reasons })
    }

    /// Why a model is not worth a test on left-out episodes, if so.
    fn doubtful(&self, candidate: &Tried) -> Result<Option<&'static str>, InferError> {
        Ok(if !(0..candidate.added.len()).all(|k| is_defined(candidate, k)) {
            Some("the data do not hold a parameter that defines an effect")
        } else if !self.fits_better(candidate)? {
            Some("an effect does not help consistently from block to block")
        } else {
            None
        })
    }

    /// Whether every effect of a model improves the density of the episodes that it is fitted to by more than chance. What
    /// does not, need not be asked of left-out episodes, which takes refits.
    fn fits_better(&self, candidate: &Tried) -> Result<bool, InferError> {
        let with = self.engine.predicted(candidate, &|_| true)?;
        let time = self.correlation_time(&with);
        for k in 0..candidate.added.len() {
            let Some(simpler) = without(self.found, candidate, k) else { return Ok(false) };
            if holds_up(time, &with, &self.engine.predicted(simpler, &|_| true)?) < SURE {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Correlation time of a fitted model's residuals, samples. Those of slow pushes are means over a second, so long that
    /// what a floor does from place to place is independent.
    fn correlation_time(&self, samples: &Samples) -> f64 {
        if self.engine.is_quasi_static() { 1.0 } else { correlation_time(samples) }
    }

    /// Of each effect of a model, the chance that left-out episodes are predicted better with it.
    fn chances(
        &self,
        candidate: &Tried,
        known: &mut BTreeMap<*const Tried, LeftOut>,
    ) -> Result<Vec<f64>, InferError> {
        let time = self.correlation_time(&self.engine.predicted(candidate, &|_| true)?);
        let with = self.misfit(candidate, candidate, known)?.samples;
        let one = |k: usize| match without(self.found, candidate, k) {
            Some(simpler) => Ok(holds_up(time, &with, &self.misfit(simpler, candidate, known)?.samples)),
            None => Ok(0.0),
        };
        (0..candidate.added.len()).map(one).collect()
    }

    /// How a model predicts left-out episodes, compared with another.
    fn misfit(
        &self,
        tried: &Tried,
        beside: &Tried,
        known: &mut BTreeMap<*const Tried, LeftOut>,
    ) -> Result<LeftOut, InferError> {
        let key = std::ptr::from_ref(tried);
        let all_judged = unscored_time(&beside.fit.model) == 0.0;
        if let Some(misfit) = known.get(&key).filter(|_| all_judged) {
            return Ok(misfit.clone());
        }
        let found = left_out(self.engine, tried, beside, self.watch)?;
        known.insert(key, found.clone());
        Ok(found)
    }

    /// Whether a model with a simpler law in place of one of its effects predicts left-out episodes almost as well: then the
    /// simpler law is the one to name.
    fn has_simpler(
        &self,
        candidate: &Tried,
        known: &mut BTreeMap<*const Tried, LeftOut>,
    ) -> Result<bool, InferError> {
        for (k, effect) in candidate.added.iter().enumerate() {
            let Some(simpler) = effect.kind.simpler() else { continue };
            let mut kinds: Vec<Kind> = candidate.added.iter().map(|e| e.kind).collect();
            kinds[k] = simpler;
            let Some(other) = of_kinds(&self.found.tried, kinds) else { continue };
            let with = self.misfit(candidate, candidate, known)?;
            if with.rise(&self.misfit(other, candidate, known)?) < MATERIAL_RISE {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Effects of a model whose correction is immaterial: without them left-out episodes are predicted almost as well, or
    /// predictions err hardly more than the instruments.
    fn idle(
        &self,
        candidate: &Tried,
        known: &mut BTreeMap<*const Tried, LeftOut>,
    ) -> Result<Vec<usize>, InferError> {
        let mut misfit = |tried: &Tried| self.misfit(tried, candidate, known);
        let with = misfit(candidate)?;
        let mut idle = vec![];
        if !self.engine.errs(&self.found.tried[self.base])? {
            return Ok((0..candidate.added.len()).collect());
        }
        for k in 0..candidate.added.len() {
            let needed = match without(self.found, candidate, k) {
                Some(simpler) => {
                    with.rise(&misfit(simpler)?) >= MATERIAL_RISE && self.engine.errs(simpler)?
                }
                None => false,
            };
            if !needed {
                idle.push(k);
            }
        }
        Ok(idle)
    }
}

/// Whether the data hold what makes an effect the effect that it is: every essential parameter but for places and
/// directions, and at least one of those any of which defines it. A load whose frequency is unknown is an offset mass.
fn is_defined(candidate: &Tried, k: usize) -> bool {
    let names = candidate.fit.model.effect_names();
    let name = &names[names.len() - candidate.added.len() + k];
    let spec = candidate.added[k].kind.spec();
    let identified = |p: &Param| candidate.fit.estimate(&format!("{name}.{}", p.name)).map(|e| e.identified);
    let essential =
        |p: &&Param| p.refinement.is_none() && !p.role.is_choice() && !p.of_face && !p.role.is_place();
    let of = |any: bool| spec.params.iter().filter(essential).filter(move |p| p.any_of == any);
    let any: Vec<bool> = of(true).filter_map(identified).collect();
    of(false).filter_map(identified).all(|known| known) && (any.is_empty() || any.contains(&true))
}

/// Chance that a law which leaves so much is the missing one, rather than one that is like it: even where it leaves as
/// much as is still named.
pub(crate) fn likeness(left: Option<Remainder>, observations: usize) -> f64 {
    let most = UNSEEN * observations as f64;
    left.map_or(1.0, |left| 1.0 / (1.0 + (left.misfit() / most).powi(2)))
}

/// What a named model gained on the simulation under test, nats, and what it leaves.
#[derive(Clone, Copy)]
pub(crate) struct Named {
    pub gained: f64,
    pub left: Option<Remainder>,
}

/// The verdict, given what the simulation under test leaves, what is named, if anything, and whether the errors of the
/// model that is chosen are `material`.
///
/// What was missing is what the named model gained and what a wandering wrench would gain on top of it. Where the noise is
/// not stated, the fit of the simulation under test takes unmodelled effects for noise, and such a wrench gains little there.
pub(crate) fn judge(
    observations: usize,
    before: Option<Remainder>,
    named: Option<Named>,
    material: bool,
) -> Verdict {
    let matters = |r: Option<Remainder>| material && r.is_some_and(|r| r.matters(observations));
    let Some(Named { gained, left }) = named else {
        return if matters(before) { Verdict::Unexplained } else { Verdict::Consistent };
    };
    let (Some(before), Some(after)) = (before, left) else { return Verdict::Explained };
    let missing = before.gain.max(gained + after.gain);
    let misfit = before.misfit().max(gained + after.misfit());
    let much = matters(left) && after.gain > LEFT_OVER * missing;
    let unlike = material && after.misfit() > (UNSEEN * observations as f64).max(NEGLIGIBLE_SHARE * misfit);
    if much || unlike { Verdict::Unexplained } else { Verdict::Explained }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::{Named, correlation_time, holds_up, is_defined, judge, left_out, likeness};
    use crate::adequacy::Remainder;
    use crate::answer::{Value, Verdict};
    use crate::common::{World, effect, locked};
    use crate::engine::{Engine, Own, Tried};
    use crate::{Options, diagnose};
    use trundle_infer::{Channels, Comparison, FitOptions, Quiet, fit};
    use trundle_model::{Effect, Kind, Model};

    const SAMPLES: usize = 2000;

    fn leaving(gain: f64, excess: f64) -> Option<Remainder> {
        let channels = Channels { pose: [1e-3; 3], reading: [0.4; 3], wander: [0.0; 3] };
        Some(Remainder { gain, channels, excess })
    }

    #[test]
    fn what_is_named_must_leave_little() {
        let named = |gained, left| Some(Named { gained, left });
        let judged = |left| judge(SAMPLES, leaving(5e5, 5e5), named(4e5, left), true);
        assert_eq!(judged(leaving(200.0, 400.0)), Verdict::Explained);
        assert_eq!(judged(leaving(3e4, 3e4)), Verdict::Unexplained, "a law like the missing one");
        assert_eq!(judged(leaving(0.0, 1.5e5)), Verdict::Unexplained, "blows, where no walk helps");
        // A hundredth of what was missing may be left, were it much.
        let of_much = judge(SAMPLES, leaving(4e6, 4e6), named(3e6, leaving(2e4, 2e4)), true);
        assert_eq!(of_much, Verdict::Explained);
        // Of little, most must go.
        let of_little =
            |gained| judge(SAMPLES, leaving(100.0, 100.0), named(gained, leaving(40.0, 40.0)), true);
        assert_eq!(of_little(60.0), Verdict::Unexplained);
        assert_eq!(of_little(1000.0), Verdict::Explained, "what was missing had passed for noise");
    }

    #[test]
    fn without_a_name_it_is_what_is_missing_that_counts() {
        assert_eq!(judge(SAMPLES, leaving(3.0, 300.0), None, true), Verdict::Consistent);
        assert_eq!(judge(SAMPLES, leaving(300.0, 300.0), None, true), Verdict::Unexplained);
        let immaterial = judge(SAMPLES, leaving(300.0, 300.0), None, false);
        assert_eq!(immaterial, Verdict::Consistent);
    }

    #[test]
    fn a_law_is_the_less_likely_the_more_it_leaves() {
        assert!(likeness(leaving(0.0, 100.0), SAMPLES) > 0.99);
        assert!((likeness(leaving(4000.0, 0.0), SAMPLES) - 0.5).abs() < 1e-12);
        assert_eq!(likeness(None, SAMPLES), 1.0);
    }

    /// The chance that a slope which is fitted to pushes of a world predicts left-out pushes better.
    fn chance_of_slope(truth: Model) -> f64 {
        let data = World::of(truth).recording(4);
        let comparison = Comparison::of(&data).unwrap();
        let engine = Own::new(&data, None).unwrap();
        let predicted = |added: Vec<Effect>| {
            let nominal = engine.nominal();
            let model =
                Model { effects: [nominal.effects.clone(), added.clone()].concat(), ..nominal.clone() };
            let fitted = fit(&comparison, &model, &[], &FitOptions::default(), &Quiet).unwrap();
            let tried = Tried::new(added, fitted, None);
            left_out(&engine, &tried, &tried, &Quiet).unwrap().samples
        };
        let with = predicted(vec![Effect::free(Kind::FloorSlope)]);
        holds_up(correlation_time(&with), &with, &predicted(vec![]))
    }

    #[test]
    fn a_true_effect_predicts_left_out_episodes_and_a_false_one_does_not() {
        let slope = effect(Kind::FloorSlope, &[("accel_x", 0.05), ("accel_y", -0.02)]);
        assert!(chance_of_slope(locked().with(slope)) > 0.99);
        assert!(chance_of_slope(locked()) < 0.9);
    }

    #[test]
    fn where_the_object_was_weighed_a_common_gain_is_no_load() {
        let mut data = World::of(locked()).recording(3);
        data.mass_given = Some(22.0);
        for sample in data.training.iter_mut().chain(&mut data.held_out).flat_map(|e| &mut e.wrench) {
            sample.reading = [0, 1, 2].map(|k| sample.reading[k] * [0.7, 1.5, 1.3][k]);
        }
        let found = diagnose(&data, &Options::default(), &Quiet).unwrap().answer;
        let names: Vec<_> = found.missing.iter().map(|m| m.effect.as_str()).collect();
        assert_eq!(names, ["force_scale"], "{:?}", found.verdict);
        let Value::Number(gain) = &found.missing[0].parameters["gain_x"] else { panic!("no number") };
        assert!((gain.mean - 0.7).abs() < 0.02, "{gain:?}");
    }

    /// A recording's fit with one effect, of whose parameters the data hold `known` and no other.
    fn holding(kind: Kind, known: &[&str]) -> Tried {
        let data = World::of(locked()).recording(4);
        let added = vec![Effect::free(kind)];
        let nominal = Own::new(&data, None).unwrap().nominal().clone();
        let model = Model { effects: [nominal.effects.clone(), added.clone()].concat(), ..nominal };
        let options = FitOptions { starts: 1, ..FitOptions::default() };
        let mut fitted = fit(&Comparison::of(&data).unwrap(), &model, &[], &options, &Quiet).unwrap();
        for estimate in &mut fitted.estimates {
            estimate.identified = known.iter().any(|key| estimate.name.ends_with(&format!(".{key}")));
        }
        Tried::new(added, fitted, None)
    }

    #[test]
    fn of_several_limits_one_that_was_reached_defines_a_saturation() {
        assert!(is_defined(&holding(Kind::Saturation, &["limit_torque"]), 0));
        assert!(!is_defined(&holding(Kind::Saturation, &[]), 0));
    }

    #[test]
    fn a_gain_of_one_axis_is_wrong_where_no_torque_is_recorded() {
        assert!(is_defined(&holding(Kind::ForceScale, &["gain_y"]), 0));
        assert!(!is_defined(&holding(Kind::ForceScale, &[]), 0));
    }

    #[test]
    fn a_swinging_load_without_its_frequency_is_not_defined() {
        let all: Vec<&str> = Kind::SwingingLoad.spec().params.iter().map(|p| p.name).collect();
        assert!(is_defined(&holding(Kind::SwingingLoad, &all), 0));
        let rest: Vec<&str> = all.into_iter().filter(|key| *key != "frequency").collect();
        assert!(!is_defined(&holding(Kind::SwingingLoad, &rest), 0));
    }
}
