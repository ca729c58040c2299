//! The whole of a diagnosis, in order.

use crate::adequacy::{Remainder, remainder};
use crate::answer::{Answer, Figures, Mismatch, Nominal, Pair, Place, Remaining, Verdict};
use crate::enough::enough;
use crate::locate::{located, mismatch};
use crate::naming::{effect_probability, judged, named};
use crate::nominal::{as_given, given_values, parameters, under_test};
use crate::outlook::outlook;
use crate::predictions::Predictions;
use crate::rivals::doubts;
use crate::search::{Found, Searcher, Tried, probabilities};
use crate::series::{self, Series};
use crate::thresholds::given_margin;
use crate::units;
use crate::unnamed::{depends_on, unnamed};
use crate::verdict::{Choice, Judge, judge, likeness};
use crate::warnings::warnings;
use trundle_infer::{Comparison, Fit, InferError, Likelihood, Watch, unjudged};
use trundle_model::{Model, Scales};
use trundle_record::{Dataset, PrepareOptions, Prepared, Recording, prepare_with};

/// How a diagnosis is made.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Seed of every random start.
    pub seed: u64,
    /// The simulation under test; the paper's when not given.
    pub model: Option<Model>,
    /// Names of effects that are not to be tried.
    pub without: Vec<String>,
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

/// Diagnose a prepared recording, whose lengths, forces and times are those of furniture.
///
/// # Errors
/// When there is not enough data, or the user interrupts.
pub fn diagnose(data: &Dataset, options: &Options, watch: &dyn Watch) -> Result<Outcome, InferError> {
    let decided = decide(data, options, options.model.as_ref(), watch)?;
    explain(data, options, decided, watch)
}

/// Diagnose a recording of any size: it is sought and decided in the recording's own units ([`units`]), and explained in SI
/// units. `data` is the recording prepared with `prepare`.
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
    let unscalable = options.model.as_ref().is_some_and(|model| model.unnamed.is_some());
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
    let decided = decide(&reduced, options, model.as_ref(), watch)?;
    explain(data, options, decided.restored(data, options, &scales)?, watch)
}

/// What was decided, before it is explained. Models are indices into what was tried.
struct Decision {
    found: Found,
    base: usize,
    best: usize,
    chances: Vec<f64>,
    rejected: usize,
    immaterial: Vec<(usize, usize, f64)>,
    /// What the best model leaves.
    left: Option<Remainder>,
    given: Option<Fit>,
    verdict: Verdict,
}

/// Fit, search and decide.
fn decide(
    data: &Dataset,
    options: &Options,
    model: Option<&Model>,
    watch: &dyn Watch,
) -> Result<Decision, InferError> {
    let (nominal, given) = under_test(data, model);
    enough(data)?;
    let comparison = Comparison::of(data)?;
    let searcher = Searcher {
        comparison: &comparison,
        nominal: &nominal,
        commanded: data.commanded,
        episodes: &data.training,
        without: &options.without,
        regions: &[],
        seed: options.seed,
        watch,
    };
    let found = searcher.run()?;
    watch.progress("left-out episodes", 0.0);
    let base = found.tried.iter().position(|t| t.added.is_empty()).unwrap_or(0);
    let judge_of = Judge { data, comparison: &comparison, nominal: &nominal, found: &found, base, watch };
    let Choice { mut best, mut chances, rejected, immaterial } = judge_of.choose()?;
    let fit = |k: usize| &found.tried[k].fit;
    let mut left = remainder(&comparison, fit(best))?;
    let ahead = outlook(data, fit(best))?;
    let slow = comparison.is_quasi_static();
    let named = best != base;
    let mut verdict =
        judge(comparison.observations(), found.before, named, left, slow || ahead.is_material());
    if verdict == Verdict::Explained && !slow && ahead.is_poor() {
        verdict = Verdict::Unexplained;
    }
    if verdict == Verdict::Unexplained {
        (best, chances, left) = (base, vec![], found.before);
    }
    let given = given.as_ref().map(|g| as_given(&comparison, g, watch)).transpose()?;
    if let (Verdict::Consistent, Some(given)) = (verdict, &given)
        && given.cost - fit(base).cost > given_margin(fit(base).estimates.len())
    {
        verdict = Verdict::Reparameterised;
    }
    Ok(Decision { base, best, chances, rejected, immaterial, left, given, verdict, found })
}

impl Decision {
    /// The same in SI units, for the recording as it was prepared in them.
    fn restored(self, data: &Dataset, options: &Options, scales: &Scales) -> Result<Self, InferError> {
        let (nominal, given) = under_test(data, options.model.as_ref());
        let comparison = Comparison::of(data)?;
        let base = units::restored(&self.found.tried[self.base], &nominal, scales, 0.0)?.fit;
        let offset = comparison.with_channels(base.channels).cost(&base.model, &base.values)? - base.cost;
        let restored = |tried: &Tried| units::restored(tried, &nominal, scales, offset);
        let tried = self.found.tried.iter().map(restored).collect::<Result<Vec<_>, _>>()?;
        let before = self.found.before.map(|left| units::remainder(left, scales));
        let located = located(&comparison, &tried[self.base].fit, before, &data.training)?;
        let given = match (&self.given, &given) {
            (Some(fit), Some(model)) => Some(units::fit(fit, model, &[], scales, offset)?),
            _ => None,
        };
        let left = self.left.map(|left| units::remainder(left, scales));
        Ok(Self { found: Found { tried, before, located }, left, given, ..self })
    }
}

/// Put what was decided into numbers and words.
fn explain(
    data: &Dataset,
    options: &Options,
    decided: Decision,
    watch: &dyn Watch,
) -> Result<Outcome, InferError> {
    watch.progress("figures", 0.0);
    let Decision { found, base, best, chances, rejected, immaterial, left, given: given_fit, verdict } =
        decided;
    let (nominal, _) = under_test(data, options.model.as_ref());
    let comparison = Comparison::of(data)?;
    let (base, best) = (&found.tried[base], &found.tried[best]);
    let (all, probabilities) = (probabilities(&found.tried, 0), probabilities(&found.tried, rejected));
    let before = match (&given_fit, verdict) {
        (Some(given), Verdict::Reparameterised) => given,
        _ => &base.fit,
    };
    let mut filled = None;
    if verdict == Verdict::Unexplained {
        watch.progress("an unnamed force", 0.0);
        filled = unnamed((data, &nominal), &comparison, &base.fit, found.before, watch)?;
    }
    let after = filled.as_ref().unwrap_or(&best.fit);

    let missing_before = missing(data, &comparison, before, found.before)?;
    let missing_after = missing(data, &comparison, after, left)?;
    let again = (verdict == Verdict::Reparameterised)
        .then(|| located(&comparison, before, found.before, &data.training))
        .transpose()?;
    let mut mismatch = mismatch(&comparison, before, again.as_ref().unwrap_or(&found.located))?;
    if verdict == Verdict::Consistent {
        mismatch = Mismatch { channels: mismatch.channels, ..Mismatch::default() };
    }
    let figures = figures(data, before, after)?;
    let like = likeness(left, comparison.observations());
    let mut missing = Vec::new();
    for (k, chance) in chances.iter().enumerate() {
        let chance = chance.min(effect_probability(&found.tried, &probabilities, best.names()[k])) * like;
        missing.push(named(data, &found, best, k, chance)?);
    }
    let immaterial = immaterial
        .iter()
        .map(|&(index, k, chance)| (&found.tried[index], k, chance))
        .filter(|(tried, k, _)| !best.names().contains(&tried.names()[*k]))
        .map(|(tried, k, chance)| {
            named(
                data,
                &found,
                tried,
                k,
                chance.min(effect_probability(&found.tried, &all, tried.names()[k])),
            )
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

    // Where nothing known explains it, a push between things known would tell nothing.
    let designing = matches!(verdict, Verdict::Consistent | Verdict::Explained);
    let doubts = doubts((data, &comparison), (&found, &probabilities), best, designing, watch)?;
    let answer = Answer {
        format: "trundle-diagnosis/1",
        recording: data.name.clone(),
        verdict,
        missing,
        tied: doubts.tied,
        tied_sets: vec![],
        immaterial,
        mismatch,
        residual: remaining(&comparison, after, [found.before, left], &missing_after)?,
        warnings: warnings(data, before, after, verdict == Verdict::Explained)?,
        wrench_pose: data.wrench_pose,
        alternatives: doubts.alternatives,
        certificates: doubts.certificates,
        experiments: doubts.experiments,
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
        unnamed: filled.as_ref().map_or(vec![], depends_on),
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

/// What a fit still misses: of the motion the smoothed missing wrench, of wrenches the needed less the recorded.
fn remaining(
    comparison: &Comparison,
    fit: &Fit,
    [before, after]: [Option<Remainder>; 2],
    missing: &series::Missing,
) -> Result<Remaining, InferError> {
    let wrenches: Vec<[f64; 3]> = match comparison {
        Comparison::Motion(_) => {
            missing.training.iter().flatten().flatten().map(|residual| residual.wrench).collect()
        }
        Comparison::Wrench(slow) => {
            let plant = fit.model.plant(&fit.values)?;
            slow.samples().iter().map(|sample| sample.residual(&plant)).collect()
        }
    };
    let mean = |of: &dyn Fn(&[f64; 3]) -> f64| {
        let sum: f64 = wrenches.iter().map(of).sum();
        (!wrenches.is_empty()).then(|| (sum / wrenches.len() as f64).sqrt())
    };
    let planar = fit.model.dof[1];
    let share = before.zip(after).filter(|(before, _)| before.misfit() > 0.0);
    Ok(Remaining {
        force_rms: mean(&|w| w[0] * w[0] + if planar { w[1] * w[1] } else { 0.0 }),
        torque_rms: mean(&|w| w[2] * w[2]).filter(|_| fit.model.dof[2]),
        share: share.map(|(before, after)| (after.misfit() / before.misfit()).min(1.0)),
        ..Remaining::default()
    })
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

fn figures(data: &Dataset, before: &Fit, after: &Fit) -> Result<Figures, InferError> {
    let pair = |episodes: &[Prepared]| {
        Ok::<_, InferError>(Pair {
            before: judged(data, before, after, episodes)?,
            after: judged(data, after, before, episodes)?,
        })
    };
    let held_out = if data.held_out.is_empty() { None } else { Some(pair(&data.held_out)?) };
    Ok(Figures { held_out, training: pair(&data.training)? })
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
    let settling = unjudged(&before.model).max(unjudged(&after.model));
    let (before, after) = (before.model.plant(&before.values)?, after.model.plant(&after.values)?);
    let shown = |plant| (!quasi_static).then_some(plant);
    Ok(Predictions::new(
        data.held_out.iter(),
        &[("before", shown(&before)), ("after", shown(&after))],
        settling,
    ))
}
