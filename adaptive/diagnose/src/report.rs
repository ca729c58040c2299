//! The report of a decision: the answer, the tables and the curves.

use crate::answer::{
    Answer, BeforeAfter, ErrorMetrics, Mismatch, MissingEffect, Nominal, Place, ResidualSummary, Verdict,
};
use crate::competing_models::competing_models;
use crate::decision::Decision;
use crate::discrepancy::input_descriptions;
use crate::effect_report::{effect_probability, reported_effect, without_effect};
use crate::engine::Engine;
use crate::fitted_model::FittedModel;
use crate::lack_of_fit::LackOfFit;
use crate::locate::Located;
use crate::missing_wrenches::MissingWrenches;
use crate::periods;
use crate::platt::calibrated;
use crate::predictions::Predictions;
use crate::search::{SearchResult, probabilities};
use crate::series::{self, Series};
use crate::verdict::{NamedModel, own_effect_probability, right_law_probability};
use crate::warnings::{doubted_laws, harmful_effect, neglected_lack_of_fit, warnings};
use std::collections::BTreeMap;
use trundle_infer::{InferError, Watch, unscored_time};
use trundle_record::Prepared;

/// Least probability of an immaterial effect that is reported.
const MIN_IMMATERIAL_PROBABILITY: f64 = 0.5;

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

/// Make the answer, the tables and the curves from a decision.
///
/// # Errors
/// If the simulation fails, or the user interrupts.
pub(crate) fn report(
    engine: &dyn Engine,
    decision: &Decision,
    watch: &dyn Watch,
) -> Result<Outcome, InferError> {
    watch.progress("error metrics", 0.0);
    let reporter = Reporter::new(engine, decision, watch)?;
    let (before, after) = (reporter.before(), reporter.after());
    Ok(Outcome {
        answer: reporter.answer(watch)?,
        series: reporter.series()?,
        model: engine.model_toml(after)?,
        predictions: predictions(engine, before, after)?,
    })
}

/// The models that a report compares.
struct Reporter<'a> {
    engine: &'a dyn Engine,
    decision: &'a Decision,
    /// Probabilities of the fitted models, of all and of those that are not rejected.
    all_probabilities: Vec<f64>,
    probabilities: Vec<f64>,
    /// The nominal model with a model discrepancy, if the verdict is "unexplained".
    with_discrepancy: Option<FittedModel>,
    missing_before: MissingWrenches,
    missing_after: MissingWrenches,
}

impl<'a> Reporter<'a> {
    fn new(engine: &'a dyn Engine, decision: &'a Decision, watch: &dyn Watch) -> Result<Self, InferError> {
        let Decision { found, base, best, lack, .. } = decision;
        let (base, best) = (&found.models[*base], &found.models[*best]);
        let mut with_discrepancy = None;
        if decision.verdict == Verdict::Unexplained {
            watch.progress("model discrepancy", 0.0);
            with_discrepancy = engine.discrepancy(base, found.before, watch)?;
        }
        let after = with_discrepancy.as_ref().unwrap_or(best);
        Ok(Self {
            engine,
            decision,
            all_probabilities: probabilities(&found.models, 0),
            probabilities: probabilities(&found.models, decision.rejected),
            missing_before: engine.missing_wrenches(decision.nominal_before(), found.before)?,
            missing_after: engine.missing_wrenches(after, *lack)?,
            with_discrepancy,
        })
    }

    fn best(&self) -> &FittedModel {
        &self.decision.found.models[self.decision.best]
    }

    /// The nominal model.
    fn before(&self) -> &FittedModel {
        self.decision.nominal_before()
    }

    /// The selected model, or the nominal one with a model discrepancy.
    fn after(&self) -> &FittedModel {
        self.with_discrepancy.as_ref().unwrap_or_else(|| self.best())
    }

    fn answer(&self, watch: &dyn Watch) -> Result<Answer, InferError> {
        let Self { engine, decision: Decision { found, given, verdict, .. }, .. } = self;
        let mut mismatch = self.mismatch()?;
        let error_metrics = error_metrics(*engine, self.before(), self.after())?;
        let missing = self.missing()?;
        let immaterial = self.immaterial()?;
        add_places(&mut mismatch, &missing);
        let warnings = self.warnings(&missing, &error_metrics)?;
        // If no known effect explains the data, an experiment between known effects is not informative.
        let designing = matches!(verdict, Verdict::Consistent | Verdict::Explained);
        let competing =
            competing_models(*engine, (found, &self.probabilities), self.best(), designing, watch)?;
        Ok(Answer {
            format: "trundle-diagnosis/1",
            recording: engine.data().name.clone(),
            verdict: *verdict,
            missing,
            tied: competing.tied,
            tied_sets: competing.tied_sets,
            immaterial,
            mismatch,
            residual: self.residual()?,
            warnings,
            wrench_pose: engine.data().wrench_pose,
            alternatives: competing.alternatives,
            certificates: competing.certificates,
            experiments: competing.experiments,
            nominal: Nominal {
                given: engine.given_values(given.as_ref()),
                before: engine.parameters(self.before()),
                after: engine.parameters(self.after()),
            },
            fit: error_metrics,
        })
    }

    /// Where the nominal model disagrees with the recording.
    fn mismatch(&self) -> Result<Mismatch, InferError> {
        let (found, verdict, before) = (&self.decision.found, self.decision.verdict, self.before());
        let relocated = (verdict == Verdict::Reparameterised)
            .then(|| self.engine.located(before, found.before))
            .transpose()?;
        let located = relocated.as_ref().unwrap_or(&found.located);
        let mismatch = located.mismatch(self.engine.channels(before)?);
        Ok(if verdict == Verdict::Consistent {
            Mismatch { channels: mismatch.channels, ..Mismatch::default() }
        } else {
            mismatch
        })
    }

    /// Probability that the laws of the best model are the right ones, by its lack of fit.
    fn law_probability(&self) -> f64 {
        let Decision { found, base, lack, .. } = self.decision;
        let named = NamedModel { gained: found.models[*base].fit.cost - self.best().fit.cost, lack: *lack };
        right_law_probability(self.engine.observations(), found.before, named)
    }

    /// The effects of the best model, those that explain most first.
    fn missing(&self) -> Result<Vec<MissingEffect>, InferError> {
        let (found, best, law_probability) = (&self.decision.found, self.best(), self.law_probability());
        let mut missing = Vec::new();
        for (k, chance) in self.decision.chances.iter().enumerate() {
            let inclusion = effect_probability(&found.models, &self.probabilities, best.names()[k]);
            let own = without_effect(found, best, k).map_or(1.0, |other| {
                own_effect_probability(other.fit.cost - best.fit.cost, self.decision.lack)
            });
            let chance = chance.min(inclusion) * law_probability * own;
            missing.push(reported_effect(self.engine, found, best, k, calibrated(chance))?);
        }
        missing.sort_by(|a, b| b.explains.unwrap_or(0.0).total_cmp(&a.explains.unwrap_or(0.0)));
        Ok(missing)
    }

    /// Immaterial effects that the best model does not contain.
    fn immaterial(&self) -> Result<Vec<MissingEffect>, InferError> {
        let (found, best) = (&self.decision.found, self.best());
        let one = |(fitted, k, chance): (&FittedModel, usize, f64)| {
            let inclusion = effect_probability(&found.models, &self.all_probabilities, fitted.names()[k]);
            reported_effect(self.engine, found, fitted, k, calibrated(chance.min(inclusion)))
        };
        let is_probable = |effect: &Result<MissingEffect, InferError>| {
            effect.as_ref().map_or(true, |effect| effect.probability >= MIN_IMMATERIAL_PROBABILITY)
        };
        self.decision
            .immaterial
            .iter()
            .map(|&(index, k, chance)| (&found.models[index], k, chance))
            .filter(|(fitted, k, _)| !best.names().contains(&fitted.names()[*k]))
            .map(one)
            .filter(is_probable)
            .collect()
    }

    fn warnings(&self, missing: &[MissingEffect], metrics: &ErrorMetrics) -> Result<Vec<String>, InferError> {
        let (engine, verdict) = (self.engine, self.decision.verdict);
        let mut found = warnings(engine, self.before(), self.after(), verdict == Verdict::Explained)?;
        if !engine.data().held_out.is_empty() {
            found.extend(missing.iter().filter_map(|effect| harmful_effect(&effect.effect, effect.explains)));
        }
        found.extend(doubted_laws(verdict, self.law_probability()));
        let unseen = metrics.held_out.as_ref().map(|pair| &pair.after);
        let lack = self.decision.found.before;
        found.extend(neglected_lack_of_fit(verdict, lack, engine.observations(), unseen));
        Ok(found)
    }

    /// What remains. A model discrepancy predicts but explains nothing, so that the residual is then that of the nominal
    /// model.
    fn residual(&self) -> Result<ResidualSummary, InferError> {
        let (engine, Decision { found, lack, verdict, .. }) = (self.engine, self.decision);
        let (model, missing) = match &self.with_discrepancy {
            Some(_) => (self.before(), &self.missing_before),
            None => (self.after(), &self.missing_after),
        };
        let summary = residual_summary(engine, model, [found.before, *lack], missing)?;
        if *verdict == Verdict::Consistent {
            return Ok(summary);
        }
        let Located { windows, regime, .. } = engine.located(model, *lack)?;
        let courses = missing.training.clone().unwrap_or_default();
        let is_on_rail = engine.data().dof == [true, false, false];
        let periods = periods::for_answer([&courses, &engine.unsmoothed(self.after())?], is_on_rail);
        let regime_kind = regime.as_ref().map(|r| r.kind);
        let regime = regime.map(|r| r.description);
        Ok(ResidualSummary { windows, regime, regime_kind, periods, ..summary })
    }

    /// Curves and tables of the report.
    fn series(&self) -> Result<Series, InferError> {
        let (engine, after) = (self.engine, self.after());
        let (data, nominal, quasi_static) = (engine.data(), engine.nominal(), engine.is_quasi_static());
        let axes = ["x", "y", "theta"].into_iter().zip(data.dof);
        let missing = [&self.missing_before, &self.missing_after];
        let Decision { found, reasons, .. } = self.decision;
        Ok(Series {
            footprint: series::outline(nominal),
            support: nominal.body.feet.clone().unwrap_or_default(),
            dof: axes.filter(|(_, moves)| *moves).map(|(name, _)| name).collect(),
            quasi_static,
            unnamed: self.with_discrepancy.as_ref().map_or(vec![], |model| input_descriptions(&model.fit)),
            noise: series::Noise {
                pose: if quasi_static { data.noise.pose } else { after.fit.channels.pose },
                force: after.fit.channels.reading[0],
                torque: after.fit.channels.reading[2],
                stated: data.noise.stated,
            },
            episodes: series::episodes(engine, [self.before(), after], missing)?,
            candidates: ranked_models(engine.observations(), found, &self.probabilities, reasons),
        })
    }
}

/// Add the places of effects to the mismatch.
fn add_places(mismatch: &mut Mismatch, missing: &[MissingEffect]) {
    let place = |key: &str| missing.iter().find_map(|m| m.place.as_ref()?.get(key).cloned());
    if let Some(Place::Point(point)) = place("body_point") {
        mismatch.body_point = Some(point.mean);
    }
    if let Some(Place::Region(corners)) = place("world_region") {
        mismatch.world_region = Some(corners);
    }
}

/// Summary of a model's residual: the smoothed missing wrench, or needed minus recorded wrenches if wrenches
/// are compared.
fn residual_summary(
    engine: &dyn Engine,
    fitted: &FittedModel,
    [before, after]: [Option<LackOfFit>; 2],
    missing: &MissingWrenches,
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
