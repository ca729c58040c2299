//! The decision of a diagnosis: the nominal fit, the search and the selected model.

use crate::answer::Verdict;
use crate::engine::Engine;
use crate::engine::plant_engine::PlantEngine;
use crate::fitted_model::FittedModel;
use crate::lack_of_fit::LackOfFit;
use crate::search::{SearchResult, Searcher};
use crate::selection::{LARGE_RESIDUAL, Selection, Selector};
use crate::thresholds::max_given_cost;
use crate::units;
use crate::verdict::verdict_of;
use std::collections::{BTreeMap, BTreeSet};
use trundle_infer::{Fit, InferError, Watch};
use trundle_model::Scales;

/// The decision, before it is reported. Models are indices into the fitted models.
pub(crate) struct Decision {
    pub found: SearchResult,
    /// Index of the nominal model.
    pub base: usize,
    /// Index of the selected model.
    pub best: usize,
    /// For each of its effects, the probability that left-out episodes are predicted better with it.
    pub chances: Vec<f64>,
    /// Number of models with more weight that contain an unsupported effect.
    pub rejected: usize,
    /// Immaterial effects: the model's index, the effect's index in it, and its probability.
    pub immaterial: Vec<(usize, usize, f64)>,
    /// Reasons for not naming fitted models.
    pub reasons: BTreeMap<usize, &'static str>,
    /// Lack of fit of the best model.
    pub lack: Option<LackOfFit>,
    /// The nominal model at the values that are given; `None` if none are.
    pub given: Option<FittedModel>,
    pub verdict: Verdict,
}

/// Fit, search and decide.
///
/// `without` has the names of effects to exclude.
///
/// # Errors
/// If the simulation fails, or the user interrupts.
pub(crate) fn decide(
    engine: &dyn Engine,
    without: &[String],
    seed: u64,
    watch: &dyn Watch,
) -> Result<Decision, InferError> {
    let searcher = Searcher::new(engine, without, seed, watch);
    let mut found = searcher.run()?;
    watch.progress("left-out episodes", 0.0);
    let base = found.models.iter().position(|t| t.added.is_empty()).unwrap_or(0);
    let Selection { mut best, mut chances, mut rejected, immaterial, mut reasons } =
        Selector { engine, found: &found, base, watch }.select()?;
    let (mut verdict, mut lack) = verdict_of(engine, found.before, &found.models[base], &found.models[best])?;
    if verdict == Verdict::Unexplained {
        reasons.entry(best).or_insert(LARGE_RESIDUAL);
        if let Some(nominal) = engine.undistorted(&found.models[base], seed, watch)? {
            found.before = engine.lack_of_fit(&nominal)?;
            found.located = engine.located(&nominal, found.before)?;
            found.models[base] = nominal;
        }
        (best, rejected, chances, lack) = (base, base, vec![], found.before);
    }
    let given = engine.given(watch)?;
    let fitted = &found.models[base].fit;
    if let (Verdict::Consistent, Some(given)) = (verdict, &given)
        && given.fit.cost - fitted.cost > max_given_cost(fitted.estimates.len())
    {
        verdict = Verdict::Reparameterised;
    }
    for index in BTreeSet::from([base, best]) {
        let richer: Vec<&Fit> = immaterial.iter().map(|(other, ..)| &found.models[*other].fit).collect();
        let widened = engine.widened(&found.models[index])?;
        found.models[index] = FittedModel { fit: widened.fit.widened_by(&richer), ..widened };
    }
    Ok(Decision { base, best, chances, rejected, immaterial, reasons, lack, given, verdict, found })
}

impl Decision {
    /// The nominal model with which the selected one is compared: at the given values if only they must change.
    pub fn nominal_before(&self) -> &FittedModel {
        match (&self.given, self.verdict) {
            (Some(given), Verdict::Reparameterised) => given,
            _ => &self.found.models[self.base],
        }
    }

    /// Convert to SI units, for the recording prepared in them.
    pub fn restored(self, engine: &PlantEngine<'_>, scales: &Scales) -> Result<Self, InferError> {
        let nominal = engine.nominal();
        let base = &self.found.models[self.base];
        let offset = engine.cost(&units::restored(base, nominal, scales, 0.0)?)? - base.fit.cost;
        let restored = |fitted: &FittedModel| units::restored(fitted, nominal, scales, offset);
        let models = self.found.models.iter().map(restored).collect::<Result<Vec<_>, _>>()?;
        let before = self.found.before.map(|lack| units::lack_of_fit(lack, scales));
        let located = engine.located(&models[self.base], before)?;
        let given = match &self.given {
            Some(given) => engine.restored(given, scales, offset)?,
            None => None,
        };
        let lack = self.lack.map(|lack| units::lack_of_fit(lack, scales));
        let found = SearchResult { models, before, located, ..self.found };
        Ok(Self { found, lack, given, ..self })
    }
}
