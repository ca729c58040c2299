//! The whole of a diagnosis, in order.

use crate::adequacy::{Remainder, remainder};
use crate::answer::{Answer, Figures, Mismatch, Nominal, Pair, Place, Verdict};
use crate::enough::enough;
use crate::locate::{located, mismatch};
use crate::naming::{effect_probability, judged, named};
use crate::nominal::{as_given, given_values, parameters, under_test};
use crate::outlook::outlook;
use crate::predictions::Predictions;
use crate::rivals::doubts;
use crate::search::{Found, Searcher, Tried, probabilities};
use crate::series::{self, Series};
use crate::unnamed::{depends_on, unnamed};
use crate::verdict::{Choice, choose, judge, likeness};
use trundle_infer::{Comparison, Fit, InferError, Watch};
use trundle_model::Model;
use trundle_record::{Dataset, Prepared};

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

/// Log likelihood that given values may cost, beyond half a nat a parameter, and still be right.
const GIVEN_MARGIN: f64 = 8.0;

/// Diagnose a recording.
///
/// # Errors
/// When there is not enough data, or the user interrupts.
pub fn diagnose(data: &Dataset, options: &Options, watch: &dyn Watch) -> Result<Outcome, InferError> {
    let (nominal, given) = under_test(data, options.model.as_ref());
    enough(data)?;
    let comparison = Comparison::of(data)?;
    let searcher = Searcher {
        comparison: &comparison,
        nominal: &nominal,
        episodes: &data.training,
        without: &options.without,
        regions: &[],
        seed: options.seed,
        watch,
    };
    let found = searcher.run()?;
    watch.progress("figures", 0.0);
    let base = found.tried.iter().find(|t| t.added.is_empty()).unwrap_or(&found.tried[0]);
    let Choice { mut best, mut chances, rejected } = choose(data, &comparison, &found)?;
    let probabilities = probabilities(&found.tried, rejected);
    let mut left = remainder(&comparison, &best.fit)?;
    let mut verdict = judge(comparison.observations(), found.before, !best.added.is_empty(), left);
    let judged_by_motion = verdict == Verdict::Explained && !comparison.is_quasi_static();
    if judged_by_motion && outlook(data, &best.fit)?.is_poor() {
        verdict = Verdict::Unexplained;
    }
    if verdict == Verdict::Unexplained {
        (best, chances, left) = (base, vec![], found.before);
    }
    let given_fit = given.as_ref().map(|g| as_given(&comparison, g, watch)).transpose()?;
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
        mismatch,
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
    let (before, after) = (before.model.plant(&before.values)?, after.model.plant(&after.values)?);
    let shown = |plant| (!quasi_static).then_some(plant);
    Ok(Predictions::new(data.held_out.iter(), &[("before", shown(&before)), ("after", shown(&after))]))
}
