//! A diagnosis from start to end.

use crate::answer::{Answer, BeforeAfter, ErrorMetrics, Mismatch, Nominal, Place, ResidualSummary, Verdict};
use crate::competing_models::competing_models;
use crate::discrepancy::input_descriptions;
use crate::effect_report::{effect_probability, reported_effect};
use crate::engine::Engine;
use crate::engine::plant_engine::PlantEngine;
use crate::fitted_model::FittedModel;
use crate::lack_of_fit::LackOfFit;
use crate::locate::Located;
use crate::periods;
use crate::platt::calibrated;
use crate::predictions::Predictions;
use crate::pushing_time::require_pushing_time;
use crate::search::{SearchResult, Searcher, probabilities};
use crate::selection::{LARGE_RESIDUAL, Selection, Selector};
use crate::series::{self, Series};
use crate::thresholds::max_given_cost;
use crate::units;
use crate::verdict::{right_law_probability, verdict_of};
use crate::warnings::{doubted_laws, harmful_effect, neglected_lack_of_fit, warnings};
use std::collections::{BTreeMap, BTreeSet};
use trundle_infer::{Fit, InferError, Watch, unscored_time};
use trundle_model::{Model, Scales};
use trundle_record::{Dataset, PrepareOptions, Prepared, Recording, prepare_with};

/// Least probability of an immaterial effect that is reported.
const MIN_IMMATERIAL_PROBABILITY: f64 = 0.5;

/// Options of a diagnosis.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Seed of every random start.
    pub seed: u64,
    /// The nominal model; the paper's if `None`.
    pub model: Option<Model>,
    /// Names of effects to exclude.
    pub without: Vec<String>,
}

/// Results of a diagnosis.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// `diagnosis.json`.
    pub answer: Answer,
    /// `model.toml`.
    pub model: String,
    /// `predictions.parquet`.
    pub predictions: Predictions,
    /// Curves for the report.
    pub series: Series,
}

/// Diagnose a prepared recording of an object of the size of furniture.
///
/// # Errors
/// If there is not enough data, or the user interrupts.
pub fn diagnose(data: &Dataset, options: &Options, watch: &dyn Watch) -> Result<Outcome, InferError> {
    require_pushing_time(data)?;
    diagnose_with(&PlantEngine::new(data, options.model.as_ref())?, options, watch)
}

/// Diagnose a recording with any engine.
///
/// # Errors
/// As [`diagnose`], and if the simulation fails.
pub(crate) fn diagnose_with(
    engine: &dyn Engine,
    options: &Options,
    watch: &dyn Watch,
) -> Result<Outcome, InferError> {
    let decision = decide(engine, options, watch)?;
    report(engine, decision, watch)
}

/// Diagnose a recording of any size. The search and the decision use the recording's own units (module `units`),
/// the report uses SI units. `data` is the recording prepared with `prepare`.
///
/// # Errors
/// As [`diagnose`].
pub fn diagnose_recording(
    recording: &Recording,
    data: &Dataset,
    prepare: PrepareOptions,
    options: &Options,
    watch: &dyn Watch,
) -> Result<Outcome, InferError> {
    let scales = units::of(data);
    let unscalable = options.model.as_ref().is_some_and(|model| model.discrepancy.is_some());
    if scales == Scales::SI || unscalable {
        return diagnose(data, options, watch);
    }
    let prepare = PrepareOptions { gravity: prepare.gravity / scales.acceleration(), ..prepare };
    let reduced =
        prepare_with(&recording.in_units(&scales), prepare).map_err(|error| InferError::NoData {
            recording: data.name.clone(),
            reason: error.to_string(),
            remedy: "check the recording with `trundle check`".to_owned(),
        })?;
    let model = options.model.as_ref().map(|model| units::reduced(model, &scales)).transpose()?;
    require_pushing_time(&reduced)?;
    let decision = decide(&PlantEngine::new(&reduced, model.as_ref())?, options, watch)?;
    let engine = PlantEngine::new(data, options.model.as_ref())?;
    report(&engine, decision.restored(&engine, &scales)?, watch)
}

/// The decision, before it is reported. Models are indices into the fitted models.
struct Decision {
    found: SearchResult,
    base: usize,
    best: usize,
    chances: Vec<f64>,
    rejected: usize,
    immaterial: Vec<(usize, usize, f64)>,
    /// Reasons for not naming fitted models.
    reasons: BTreeMap<usize, &'static str>,
    /// Lack of fit of the best model.
    lack: Option<LackOfFit>,
    given: Option<FittedModel>,
    verdict: Verdict,
}

/// Fit, search and decide.
fn decide(engine: &dyn Engine, options: &Options, watch: &dyn Watch) -> Result<Decision, InferError> {
    let searcher = Searcher::new(engine, &options.without, options.seed, watch);
    let mut found = searcher.run()?;
    watch.progress("left-out episodes", 0.0);
    let base = found.models.iter().position(|t| t.added.is_empty()).unwrap_or(0);
    let Selection { mut best, mut chances, mut rejected, immaterial, mut reasons } =
        Selector { engine, found: &found, base, watch }.select()?;
    let (mut verdict, mut lack) = verdict_of(engine, found.before, &found.models[base], &found.models[best])?;
    if verdict == Verdict::Unexplained {
        reasons.entry(best).or_insert(LARGE_RESIDUAL);
        if let Some(nominal) = engine.undistorted(&found.models[base], options.seed, watch)? {
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
    /// Convert to SI units, for the recording prepared in them.
    fn restored(self, engine: &PlantEngine<'_>, scales: &Scales) -> Result<Self, InferError> {
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

/// Make the answer, the tables and the curves from a decision.
fn report(engine: &dyn Engine, decision: Decision, watch: &dyn Watch) -> Result<Outcome, InferError> {
    watch.progress("error metrics", 0.0);
    let Decision { found, base, best, chances, rejected, immaterial, reasons, lack, given, verdict } =
        decision;
    let (data, nominal) = (engine.data(), engine.nominal());
    let (base, best) = (&found.models[base], &found.models[best]);
    let (all, probabilities) = (probabilities(&found.models, 0), probabilities(&found.models, rejected));
    let before = match (&given, verdict) {
        (Some(given), Verdict::Reparameterised) => given,
        _ => base,
    };
    let mut with_discrepancy = None;
    if verdict == Verdict::Unexplained {
        watch.progress("model discrepancy", 0.0);
        with_discrepancy = engine.discrepancy(base, found.before, watch)?;
    }
    let after = with_discrepancy.as_ref().unwrap_or(best);

    let missing_before = engine.missing_wrenches(before, found.before)?;
    let missing_after = engine.missing_wrenches(after, lack)?;
    let relocated =
        (verdict == Verdict::Reparameterised).then(|| engine.located(before, found.before)).transpose()?;
    let mut mismatch = relocated.as_ref().unwrap_or(&found.located).mismatch(engine.channels(before)?);
    if verdict == Verdict::Consistent {
        mismatch = Mismatch { channels: mismatch.channels, ..Mismatch::default() };
    }
    // A model discrepancy predicts but explains nothing, so that the residual is that of the nominal model.
    let (residual_model, missing_named) =
        if with_discrepancy.is_some() { (before, &missing_before) } else { (after, &missing_after) };
    let shown = verdict != Verdict::Consistent;
    let residual_location = if shown { engine.located(residual_model, lack)? } else { Located::default() };
    let courses = missing_named.training.clone().unwrap_or_default();
    let error_metrics = error_metrics(engine, before, after)?;
    let law_probability = right_law_probability(lack, engine.observations());
    let mut missing = Vec::new();
    for (k, chance) in chances.iter().enumerate() {
        let chance =
            chance.min(effect_probability(&found.models, &probabilities, best.names()[k])) * law_probability;
        missing.push(reported_effect(engine, &found, best, k, calibrated(chance))?);
    }
    let immaterial = immaterial
        .iter()
        .map(|&(index, k, chance)| (&found.models[index], k, chance))
        .filter(|(fitted, k, _)| !best.names().contains(&fitted.names()[*k]))
        .map(|(fitted, k, chance)| {
            reported_effect(
                engine,
                &found,
                fitted,
                k,
                calibrated(chance.min(effect_probability(&found.models, &all, fitted.names()[k]))),
            )
        })
        .filter(|effect| {
            effect.as_ref().map_or(true, |effect| effect.probability >= MIN_IMMATERIAL_PROBABILITY)
        })
        .collect::<Result<Vec<_>, InferError>>()?;
    missing.sort_by(|a, b| b.explains.unwrap_or(0.0).total_cmp(&a.explains.unwrap_or(0.0)));
    let place = |key: &str| missing.iter().find_map(|m| m.place.as_ref()?.get(key).cloned());
    if let Some(Place::Point(point)) = place("body_point") {
        mismatch.body_point = Some(point.mean);
    }
    if let Some(Place::Region(corners)) = place("world_region") {
        mismatch.world_region = Some(corners);
    }

    // If no known effect explains the data, an experiment between known effects is not informative.
    let designing = matches!(verdict, Verdict::Consistent | Verdict::Explained);
    let mut doubts = warnings(engine, before, after, verdict == Verdict::Explained)?;
    if !data.held_out.is_empty() {
        doubts.extend(missing.iter().filter_map(|effect| harmful_effect(&effect.effect, effect.explains)));
    }
    doubts.extend(doubted_laws(verdict, law_probability));
    let unseen = error_metrics.held_out.as_ref().map(|pair| &pair.after);
    doubts.extend(neglected_lack_of_fit(verdict, found.before, engine.observations(), unseen));
    let competing = competing_models(engine, (&found, &probabilities), best, designing, watch)?;
    let answer = Answer {
        format: "trundle-diagnosis/1",
        recording: data.name.clone(),
        verdict,
        missing,
        tied: competing.tied,
        tied_sets: competing.tied_sets,
        immaterial,
        mismatch,
        residual: ResidualSummary {
            windows: residual_location.windows,
            regime: residual_location.regime,
            periods: if shown {
                periods::for_answer([&courses, &engine.unsmoothed(after)?], data.dof == [true, false, false])
            } else {
                vec![]
            },
            ..residual_summary(engine, residual_model, [found.before, lack], missing_named)?
        },
        warnings: doubts,
        wrench_pose: data.wrench_pose,
        alternatives: competing.alternatives,
        certificates: competing.certificates,
        experiments: competing.experiments,
        nominal: Nominal {
            given: engine.given_values(given.as_ref()),
            before: engine.parameters(before),
            after: engine.parameters(after),
        },
        fit: error_metrics,
    };
    let quasi = engine.is_quasi_static();
    let series = Series {
        footprint: series::outline(nominal),
        support: nominal.body.feet.clone().unwrap_or_default(),
        dof: ["x", "y", "theta"]
            .into_iter()
            .zip(data.dof)
            .filter(|(_, moves)| *moves)
            .map(|(n, _)| n)
            .collect(),
        quasi_static: quasi,
        unnamed: with_discrepancy.as_ref().map_or(vec![], |model| input_descriptions(&model.fit)),
        noise: series::Noise {
            pose: if quasi { data.noise.pose } else { after.fit.channels.pose },
            force: after.fit.channels.reading[0],
            torque: after.fit.channels.reading[2],
            stated: data.noise.stated,
        },
        episodes: series::episodes(engine, [before, after], [&missing_before, &missing_after])?,
        candidates: ranked_models(engine.observations(), &found, &probabilities, &reasons),
    };
    Ok(Outcome {
        model: engine.model_toml(after)?,
        predictions: predictions(engine, before, after)?,
        answer,
        series,
    })
}

/// Summary of a model's residual: the smoothed missing wrench, or needed minus recorded wrenches if wrenches
/// are compared.
fn residual_summary(
    engine: &dyn Engine,
    fitted: &FittedModel,
    [before, after]: [Option<LackOfFit>; 2],
    missing: &crate::missing_wrenches::MissingWrenches,
) -> Result<ResidualSummary, InferError> {
    let along = || missing.training.iter().flatten().flatten().map(|residual| residual.wrench).collect();
    let wrenches: Vec<[f64; 3]> = engine.residual_wrenches(fitted)?.unwrap_or_else(along);
    let mean = |of: &dyn Fn(&[f64; 3]) -> f64| {
        let sum: f64 = wrenches.iter().map(of).sum();
        (!wrenches.is_empty()).then(|| (sum / wrenches.len() as f64).sqrt())
    };
    let dof = engine.data().dof;
    let share = before.zip(after).filter(|(before, _)| before.misfit() > 0.0);
    Ok(ResidualSummary {
        force_rms: mean(&|w| w[0] * w[0] + if dof[1] { w[1] * w[1] } else { 0.0 }),
        torque_rms: mean(&|w| w[2] * w[2]).filter(|_| dof[2]),
        share: share.map(|(before, after)| (after.misfit() / before.misfit()).min(1.0)),
        ..ResidualSummary::default()
    })
}

fn error_metrics(
    engine: &dyn Engine,
    before: &FittedModel,
    after: &FittedModel,
) -> Result<ErrorMetrics, InferError> {
    let pair = |episodes: &[Prepared]| {
        Ok::<_, InferError>(BeforeAfter {
            before: engine.score(before, after, episodes)?,
            after: engine.score(after, before, episodes)?,
        })
    };
    let data = engine.data();
    let held_out = if data.held_out.is_empty() { None } else { Some(pair(&data.held_out)?) };
    Ok(ErrorMetrics { held_out, training: pair(&data.training)? })
}

fn ranked_models(
    observations: usize,
    found: &SearchResult,
    probabilities: &[f64],
    reasons: &BTreeMap<usize, &'static str>,
) -> Vec<series::Candidate> {
    let one = |(index, (t, &probability)): (usize, (&FittedModel, &f64))| series::Candidate {
        effects: t.names().into_iter().map(str::to_owned).collect(),
        log_evidence: t.fit.log_evidence,
        log_score: Some(-t.fit.cost / observations as f64),
        probability,
        reason: reasons.get(&index).copied(),
    };
    found.models.iter().zip(probabilities).enumerate().map(one).collect()
}

fn predictions(
    engine: &dyn Engine,
    before: &FittedModel,
    after: &FittedModel,
) -> Result<Predictions, InferError> {
    let settling = unscored_time(&before.fit.model).max(unscored_time(&after.fit.model));
    let held_out = &engine.data().held_out;
    let poses = |fitted: &FittedModel| -> Result<Vec<[f64; 3]>, InferError> {
        let mut all = vec![];
        for episode in held_out {
            let simulated = engine.open_loop(fitted, episode)?;
            all.extend(simulated.unwrap_or_else(|| vec![[f64::NAN; 3]; episode.pose.len()]));
        }
        Ok(all)
    };
    let groups = vec![("before", poses(before)?), ("after", poses(after)?)];
    Ok(Predictions::simulated(held_out.iter(), groups, settling))
}
