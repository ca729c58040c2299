//! The whole of a diagnosis, in order.

use crate::adequacy::Remainder;
use crate::answer::{
    Alternative, Answer, Figures, Mismatch, Missing, Nominal, Pair, Parameter, Point, Quantity, Verdict,
};
use crate::candidates::name;
use crate::confirm::holds_up;
use crate::locate::{Residuals, locate};
use crate::predictions::Predictions;
use crate::search::{Found, Searcher, Tried, probabilities};
use crate::series::{self, Series};
use crate::words::statement;
use std::collections::BTreeMap;
use trundle_infer::{Comparison, Fit, InferError, Score, Watch, quasi_static, score};
use trundle_model::{Effect, Model};
use trundle_record::{Dataset, Prepared};

/// How a diagnosis is made.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Seed of every random start.
    pub seed: u64,
    /// The simulation under test; the paper's when not given.
    pub model: Option<Model>,
}

/// All that a diagnosis leaves.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// `diagnosis.json`.
    pub answer: Answer,
    /// `model.toml`.
    pub model: String,
    /// `predictions.parquet`.
    pub predictions: Predictions,
    /// What the report draws.
    pub series: Series,
}

/// Chance that an effect must have, block by block, to be named.
const SURE: f64 = 0.95;
/// Share of what was missing that named effects may leave and still explain it.
const LEFT_OVER: f64 = 0.25;
/// Difference of log likelihood below which two explanations are the same.
const TIE: f64 = 2.0;
/// Log likelihood that given values may cost, beyond half a nat a parameter, and still be right.
const GIVEN_MARGIN: f64 = 8.0;

/// Diagnose a recording.
///
/// # Errors
/// When there is not enough data, or the user interrupts.
pub fn diagnose(data: &Dataset, options: &Options, watch: &dyn Watch) -> Result<Outcome, InferError> {
    let (nominal, given) = under_test(data, options.model.as_ref());
    let comparison = Comparison::of(data)?;
    let searcher = Searcher { comparison: &comparison, nominal: &nominal, seed: options.seed, watch };
    let found = searcher.run()?;
    watch.progress("figures", 0.0);
    let probabilities = probabilities(&found.tried);
    let base = found.tried.iter().find(|t| t.added.is_empty()).unwrap_or(&found.tried[0]);
    let (mut best, chances) = choose(&comparison, &found)?;
    let mut chances = chances;
    let mut verdict = judge(&comparison, &found, best);
    if verdict == Verdict::Unexplained {
        (best, chances) = (base, vec![]);
    }
    let given_fit = given.as_ref().map(|g| as_given(&comparison, g)).transpose()?;
    if let (Verdict::Consistent, Some(given)) = (verdict, &given_fit) {
        let margin = GIVEN_MARGIN + 0.5 * base.fit.estimates.len() as f64;
        if given.cost - base.fit.cost > margin {
            verdict = Verdict::Reparameterised;
        }
    }
    let before = match (&given_fit, verdict) {
        (Some(given), Verdict::Reparameterised) => given,
        _ => &base.fit,
    };
    let after = &best.fit;

    let names: Vec<String> = data.training.iter().map(|e| e.name.clone()).collect();
    let missing_before = missing(data, &comparison, before, found.before)?;
    let missing_after = missing(data, &comparison, after, found.after)?;
    let none = Residuals::new();
    let mut mismatch =
        locate(&comparison, before, missing_before.training.as_ref().unwrap_or(&none), &names)?;
    if verdict == Verdict::Consistent {
        mismatch = Mismatch { channels: mismatch.channels, ..Mismatch::default() };
    }
    let figures = figures(data, before, after)?;
    let mut missing = Vec::new();
    for (k, chance) in chances.iter().enumerate() {
        let chance = chance.min(effect_probability(&found.tried, &probabilities, best.names()[k]));
        missing.push(named(data, &found, best, k, chance)?);
    }
    missing.sort_by(|a, b| b.explains.unwrap_or(0.0).total_cmp(&a.explains.unwrap_or(0.0)));
    let point = missing.iter().find_map(|m| m.place.as_ref()?.get("body_point").map(|p| p.mean));
    mismatch.body_point = point.or(mismatch.body_point);

    let answer = Answer {
        format: "trundle-diagnosis/1",
        recording: data.name.clone(),
        verdict,
        missing,
        tied: ties(&found, best),
        mismatch,
        alternatives: alternatives(&found, &probabilities, best),
        nominal: Nominal {
            given: given_values(&given_fit),
            before: parameters(before, &nominal),
            after: parameters(after, &nominal),
        },
        fit: figures,
    };
    let quasi = comparison.is_quasi_static();
    let series = Series {
        footprint: series::outline(&nominal),
        support: nominal.body.feet.clone().unwrap_or_default(),
        dof: ["x", "y", "theta"]
            .into_iter()
            .zip(data.dof)
            .filter(|(_, moves)| *moves)
            .map(|(n, _)| n)
            .collect(),
        quasi_static: quasi,
        noise: series::Noise {
            pose: if quasi { data.noise.pose } else { after.channels.pose },
            force: after.channels.reading[0],
            torque: after.channels.reading[2],
            stated: data.noise.stated,
        },
        episodes: series::episodes(data, &comparison, [before, after], [&missing_before, &missing_after])?,
        candidates: tried(&comparison, &found, &probabilities),
    };
    Ok(Outcome {
        model: written(after, quasi)?,
        predictions: predictions(data, before, after, quasi)?,
        answer,
        series,
    })
}

/// A model file's model for the object of a recording: directions, shape and feet from the recording where the
/// file does not say; the paper's model without a file.
pub fn for_recording(data: &Dataset, model: Option<&Model>) -> Model {
    let Some(model) = model else {
        return Model::nominal(data.body.clone(), data.mass_given, data.dof);
    };
    let mut model = Model { dof: data.dof, ..model.clone() };
    if model.body.fixtures.is_empty() {
        let mass = model.mass.unwrap_or(data.body.mass);
        model.body = trundle_model::Body { mass, ..data.body.clone() };
    }
    if let (None, Some(feet)) = (&model.body.feet, &data.body.feet) {
        model.body = model.body.standing_on(feet);
    }
    model
}

/// The simulation under test with its values set free, and as it was given.
fn under_test(data: &Dataset, model: Option<&Model>) -> (Model, Option<Model>) {
    let given = for_recording(data, model);
    let mut free = given.clone();
    free.mass = data.mass_given;
    free.body.mass = data.mass_given.or(given.mass).unwrap_or(data.body.mass);
    for effect in &mut free.effects {
        let params = effect.kind.spec().params;
        for (value, _) in effect.values.iter_mut().zip(params).filter(|(_, p)| p.refinement.is_none()) {
            *value = None;
        }
    }
    let has_values =
        model.is_some_and(|m| m.mass.is_some() || m.effects.iter().any(|e| *e != Effect::free(e.kind)));
    (free, has_values.then_some(given))
}

/// The given values, with whatever they leave free fitted.
fn as_given(comparison: &Comparison, given: &Model) -> Result<Fit, InferError> {
    trundle_infer::fit(comparison, given, &[], &trundle_infer::FitOptions::default(), &trundle_infer::Quiet)
}

/// The model with the most weight each of whose effects holds up block by block, and the chance of each.
fn choose<'a>(comparison: &Comparison, found: &'a Found) -> Result<(&'a Tried, Vec<f64>), InferError> {
    for candidate in &found.tried {
        let mut chances = Vec::new();
        for k in 0..candidate.added.len() {
            match without(found, candidate, k) {
                Some(simpler) => chances.push(holds_up(comparison, &candidate.fit, &simpler.fit)?),
                None => chances.push(0.0),
            }
        }
        if chances.iter().all(|c| *c >= SURE) {
            return Ok((candidate, chances));
        }
    }
    Ok((&found.tried[0], vec![]))
}

/// The tried model that lacks just one of the effects.
fn without<'a>(found: &'a Found, full: &Tried, dropped: usize) -> Option<&'a Tried> {
    let mut kinds: Vec<_> = full.added.iter().map(|e| e.kind).collect();
    kinds.remove(dropped);
    kinds.sort();
    found.tried.iter().find(|t| {
        let mut own: Vec<_> = t.added.iter().map(|e| e.kind).collect();
        own.sort();
        own == kinds
    })
}

fn judge(comparison: &Comparison, found: &Found, best: &Tried) -> Verdict {
    let observations = comparison.observations();
    let inadequate = |r: &Option<Remainder>| r.as_ref().is_some_and(|r| r.matters(observations));
    if best.added.is_empty() {
        return if inadequate(&found.before) { Verdict::Unexplained } else { Verdict::Consistent };
    }
    match (&found.before, &found.after) {
        (Some(before), Some(after)) if inadequate(&found.after) && after.gain > LEFT_OVER * before.gain => {
            Verdict::Unexplained
        }
        _ => Verdict::Explained,
    }
}

fn missing(
    data: &Dataset,
    comparison: &Comparison,
    fit: &Fit,
    remainder: Option<Remainder>,
) -> Result<series::Missing, InferError> {
    let (Some(remainder), Comparison::Motion(motion)) = (remainder, comparison) else {
        return Ok(series::Missing { training: None, held_out: None });
    };
    let over = |motion: &trundle_infer::MotionLikelihood| {
        motion.with_channels(remainder.channels).residuals(&fit.model, &fit.values)
    };
    let held_out = match Comparison::over(data, &data.held_out) {
        Ok(Comparison::Motion(held_out)) => over(&held_out)?,
        _ => None,
    };
    Ok(series::Missing { training: over(motion)?, held_out })
}

fn judged(data: &Dataset, fit: &Fit, episodes: &[Prepared]) -> Result<Score, InferError> {
    score(&fit.model, &fit.values, &fit.channels, episodes, &data.noise, quasi_static(data))
}

fn figures(data: &Dataset, before: &Fit, after: &Fit) -> Result<Figures, InferError> {
    let pair = |episodes: &[Prepared]| {
        Ok::<_, InferError>(Pair {
            before: judged(data, before, episodes)?,
            after: judged(data, after, episodes)?,
        })
    };
    let held_out = if data.held_out.is_empty() { None } else { Some(pair(&data.held_out)?) };
    Ok(Figures { held_out, training: pair(&data.training)? })
}

/// The misfit by which an effect's contribution is measured: of the motion in open loop; of the wrench, a
/// moment as a force at the radius of gyration, where wrenches are compared.
fn misfit(score: &Score, gyration: f64) -> Option<f64> {
    let moment = score.torque_rmse.map_or(0.0, |torque| torque / gyration);
    score.r2.map(|r2| 1.0 - r2).or(score.force_rmse.map(|force| force * force + moment * moment))
}

fn named(
    data: &Dataset,
    found: &Found,
    best: &Tried,
    k: usize,
    probability: f64,
) -> Result<Missing, InferError> {
    let effect = &best.added[k];
    let names = best.fit.model.effect_names();
    let name = &names[names.len() - best.added.len() + k];
    let episodes = if data.held_out.is_empty() { &data.training } else { &data.held_out };
    let gyration = best.fit.model.body.gyration;
    let with = misfit(&judged(data, &best.fit, episodes)?, gyration);
    let dropped = match without(found, best, k) {
        Some(simpler) => misfit(&judged(data, &simpler.fit, episodes)?, gyration),
        None => None,
    };
    let explains = with.zip(dropped).filter(|(_, d)| *d > 0.0).map(|(w, d)| 1.0 - w / d);
    let prefix = format!("{name}.");
    let identified = best.fit.estimates.iter().filter(|e| e.identified && e.name.starts_with(&prefix));
    let parameters = identified
        .filter_map(|e| {
            let short = e.name.strip_prefix(&prefix)?;
            let quantity = Quantity { mean: e.mean, sd: e.sd, unit: e.unit };
            (!matches!(short, "x" | "y")).then(|| (short.to_owned(), quantity))
        })
        .collect();
    Ok(Missing {
        effect: effect.kind.spec().effect.to_owned(),
        probability,
        statement: statement(effect, name, &best.fit),
        parameters,
        place: body_point(&best.fit, name).map(|p| BTreeMap::from([("body_point", p)])),
        explains,
    })
}

/// Where an effect with a position acts, if the data hold it.
fn body_point(fit: &Fit, name: &str) -> Option<Point> {
    let coordinate = |axis: &str| fit.estimate(&format!("{name}.{axis}")).filter(|e| e.identified);
    let (x, y) = (coordinate("x")?, coordinate("y")?);
    Some(Point { mean: [x.mean, y.mean], sd: [x.sd, y.sd] })
}

fn effect_probability(tried: &[Tried], probabilities: &[f64], name: &str) -> f64 {
    tried.iter().zip(probabilities).filter(|(t, _)| t.names().contains(&name)).map(|(_, p)| p).sum()
}

/// Effects that could stand in another's place without the likelihood telling.
fn ties(found: &Found, best: &Tried) -> Vec<Vec<String>> {
    let mut sets = Vec::new();
    for effect in &best.added {
        let mut set = vec![name(effect).to_owned()];
        set.extend(
            rivals(found, best)
                .filter(|(own, _)| own.kind == effect.kind)
                .map(|(_, other)| name(other).to_owned()),
        );
        set.dedup();
        if set.len() > 1 {
            sets.push(set);
        }
    }
    sets
}

/// Pairs of an effect of a model and another that could stand in its place without the likelihood telling.
fn rivals<'a>(found: &'a Found, model: &'a Tried) -> impl Iterator<Item = (&'a Effect, &'a Effect)> {
    let lacking = |from: &'a Tried, other: &'a Tried| {
        from.added.iter().filter(|e| other.added.iter().all(|o| o.kind != e.kind)).collect::<Vec<_>>()
    };
    found.tried.iter().filter_map(move |other| {
        let same = other.added.len() == model.added.len() && other.fit.cost - model.fit.cost < TIE;
        match (lacking(model, other).as_slice(), lacking(other, model).as_slice()) {
            ([own], [rival]) if same && name(own) != name(rival) => Some((*own, *rival)),
            _ => None,
        }
    })
}

/// At most this many alternatives are told.
const ALTERNATIVES: usize = 5;

fn alternatives(found: &Found, probabilities: &[f64], best: &Tried) -> Vec<Alternative> {
    let other = |(t, _): &(&Tried, &f64)| !t.added.is_empty() && t.names() != best.names();
    found
        .tried
        .iter()
        .zip(probabilities)
        .filter(other)
        .take(ALTERNATIVES)
        .map(|(t, &probability)| {
            let new = t.added.iter().find(|e| best.added.iter().all(|b| b.kind != e.kind));
            let twins = rivals(found, t).filter(|(own, _)| new.is_some_and(|new| new.kind == own.kind));
            let twins: Vec<_> = twins.map(|(_, rival)| name(rival)).collect();
            let mut experiment = new.map_or(String::new(), |e| e.kind.spec().probe.to_owned());
            if !twins.is_empty() {
                experiment = format!("these pushes cannot tell it from {}: {experiment}", twins.join(", "));
            }
            Alternative { effect: t.names().join(" + "), probability, experiment }
        })
        .collect()
}

fn given_values(given: &Option<Fit>) -> BTreeMap<String, f64> {
    let Some(fit) = given else { return BTreeMap::new() };
    let free = |name: &str| fit.estimate(name).is_some();
    let slots = fit.model.slots();
    slots.into_iter().filter(|s| !free(&s.name)).filter_map(|s| Some((short(&s.name), s.value?))).collect()
}

/// `mass` rather than `body.mass`.
fn short(name: &str) -> String {
    name.strip_prefix("body.").unwrap_or(name).to_owned()
}

/// Parameters of the simulation under test within a fit.
fn parameters(fit: &Fit, nominal: &Model) -> BTreeMap<String, Parameter> {
    let own: Vec<String> = nominal.slots().into_iter().map(|s| s.name).collect();
    let one = |e: &trundle_infer::Estimate| {
        let kept = |value: f64| e.identified.then_some(value);
        let parameter =
            Parameter { mean: kept(e.mean), sd: kept(e.sd), unit: e.unit, identifiable: e.identified };
        (short(&e.name), parameter)
    };
    fit.estimates.iter().filter(|e| own.contains(&e.name)).map(one).collect()
}

fn tried(comparison: &Comparison, found: &Found, probabilities: &[f64]) -> Vec<series::Candidate> {
    let count = comparison.observations() as f64;
    let one = |(t, &probability): (&Tried, &f64)| series::Candidate {
        effects: t.names().into_iter().map(str::to_owned).collect(),
        log_evidence: t.fit.log_evidence,
        log_score: Some(-t.fit.cost / count),
        probability,
    };
    found.tried.iter().zip(probabilities).map(one).collect()
}

/// `model.toml`; a mass that slow pushes do not hold is left free.
fn written(fit: &Fit, quasi_static: bool) -> Result<String, InferError> {
    let mut model = fit.model.clone();
    if quasi_static && fit.estimate("body.mass").is_some() {
        model.mass = None;
    }
    Ok(model.to_toml(fit.posterior().as_ref())?)
}

fn predictions(
    data: &Dataset,
    before: &Fit,
    after: &Fit,
    quasi_static: bool,
) -> Result<Predictions, InferError> {
    let (before, after) = (before.model.plant(&before.values)?, after.model.plant(&after.values)?);
    let shown = |plant| (!quasi_static).then_some(plant);
    Ok(Predictions::new(data.held_out.iter(), &[("before", shown(&before)), ("after", shown(&after))]))
}
