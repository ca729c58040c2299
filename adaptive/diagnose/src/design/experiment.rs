//! Discriminating experiments.

use super::competing_model::CompetingModel;
use super::instructions::{instructions, rounded};
use super::push::Push;
use super::search::{MIN_SEPARATION_NATS, MutualMisfit, PushSearch, Trial};
use super::setup::Setup;
use crate::thresholds::MIN_EFFECT_PROBABILITY;
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, Normal};
use trundle_infer::{InferError, Watch};

/// A push of an experiment.
#[derive(Clone, Debug, Serialize)]
pub struct PlannedPush {
    /// The push.
    #[serde(flatten)]
    pub push: Push,
    /// Its command: rows `[t, f_x, f_y, τ]`, t in s since contact, gripper axes.
    pub knots: Vec<[f64; 4]>,
    /// Expected separation by this push alone, averaged over which model is true, nats.
    pub separation: f64,
    /// Expected separation by all pushes up to this one, nats.
    pub cumulative: f64,
    /// Instructions in words.
    pub sentence: String,
}

/// The pushes that best discriminate between two models.
#[derive(Clone, Debug, Serialize)]
pub struct Experiment {
    /// Names of the two models.
    pub models: [String; 2],
    /// Pushes, best first; empty if no push is informative.
    pub pushes: Vec<PlannedPush>,
    /// Expected log-likelihood ratio against the best refit of the other model, if the first model is true and if the
    /// second is, nats.
    pub separation: [f64; 2],
    /// Log-likelihood ratio of the recording in favour of the first model, nats.
    pub recorded: f64,
    /// Probability that the true model reaches a posterior probability of 0.95, averaged over which model is true.
    pub sure: f64,
    /// Number of repetitions of all pushes for which `sure` is at least 0.95; `None` if it exceeds the maximum.
    pub repeats: Option<u32>,
    /// Summary in words.
    pub sentence: String,
}

/// Maximum number of repetitions that is considered.
const MAX_REPEATS: u32 = 50;

/// Selects the `count` pushes that best discriminate between two models, one after the other.
///
/// # Errors
/// If a model cannot be evaluated, or if the user interrupts.
pub fn experiment(
    setup: &Setup,
    first: &CompetingModel,
    second: &CompetingModel,
    count: usize,
    watch: &dyn Watch,
) -> Result<Experiment, InferError> {
    let models = [first, second];
    let search = PushSearch::new(setup, models, watch)?;
    let (mut misfit, mut chosen) = (MutualMisfit::none(&models), Vec::<Trial>::new());
    for k in 0..count {
        watch.progress("designing pushes", k as f64 / count as f64);
        let Some(best) = search.best(&misfit, setup.recorded_episodes + k)? else { break };
        misfit = best.misfit.clone();
        chosen.push(best);
    }
    let pushes: Vec<Push> = chosen.iter().map(|t| t.push).collect();
    let separation = if pushes.is_empty() { [0.0; 2] } else { search.separations_after_refit(&pushes)? };
    let planned = chosen.iter().map(|t| PlannedPush {
        push: t.push,
        knots: t.push.knots(),
        separation: t.separation,
        cumulative: t.cumulative,
        sentence: instructions(&t.push, setup),
    });
    let recorded = second.cost - first.cost;
    Ok(assemble([first.name.clone(), second.name.clone()], planned.collect(), separation, recorded))
}

pub(super) fn assemble(
    models: [String; 2],
    pushes: Vec<PlannedPush>,
    separation: [f64; 2],
    recorded: f64,
) -> Experiment {
    let sure = success_probability(separation, recorded, 1);
    let repeats = if pushes.is_empty() { None } else { needed_repeats(separation, recorded) };
    let sentence = summary(&models, &pushes, separation, sure, repeats);
    Experiment { models, pushes, separation, recorded, sure, repeats, sentence }
}

/// Number of repetitions for which [`success_probability`] reaches 0.95; `None` if it exceeds the maximum.
#[must_use]
pub fn needed_repeats(separation: [f64; 2], recorded: f64) -> Option<u32> {
    (1..=MAX_REPEATS).find(|n| success_probability(separation, recorded, *n) >= MIN_EFFECT_PROBABILITY)
}

/// Probability that the true model's posterior probability exceeds 0.95 after `n` repetitions, averaged over
/// which model is true. A log-likelihood ratio with mean `D` under the true model is normal with variance `2 D`.
#[must_use]
pub fn success_probability([first, second]: [f64; 2], recorded: f64, n: u32) -> f64 {
    let needed = (MIN_EFFECT_PROBABILITY / (1.0 - MIN_EFFECT_PROBABILITY)).ln();
    let one = |separation: f64, prior_ratio: f64| {
        let mean = f64::from(n) * separation;
        let margin = prior_ratio + mean - needed;
        Normal::new(0.0, 1.0).map_or(0.0, |normal| normal.cdf(margin / (2.0 * mean).max(1e-9).sqrt()))
    };
    0.5 * (one(first, recorded) + one(second, -recorded))
}

fn summary(
    [first, second]: &[String; 2],
    pushes: &[PlannedPush],
    separation: [f64; 2],
    sure: f64,
    repeats: Option<u32>,
) -> String {
    if pushes.is_empty() {
        return format!("No push within the limits distinguishes {first} from {second}.");
    }
    let all: Vec<&str> = pushes.iter().map(|p| p.sentence.as_str()).collect();
    let nats = |value: f64| if value > 1000.0 { "over 1000".to_owned() } else { rounded(value) };
    let [a, b] = separation.map(nats);
    let repeats = match repeats {
        Some(1) => String::new(),
        Some(n) => format!("; with {n} repetitions it is at least 95 %"),
        None => "; repetitions do not raise it to 95 %".to_owned(),
    };
    format!(
        "{} The expected log-likelihood ratio is {a} nats if {first} is true and {b} nats if {second} is true. \
         The chance that the true model then has a probability above 0.95 is {:.0} %{repeats}.",
        all.join(" Then: "),
        100.0 * sure
    )
}

impl Experiment {
    /// Whether the pushes discriminate between the models.
    pub fn is_informative(&self) -> bool {
        !self.pushes.is_empty() && self.separation.iter().sum::<f64>() > MIN_SEPARATION_NATS
    }
}
