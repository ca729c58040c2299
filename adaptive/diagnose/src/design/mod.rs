//! Telling two models apart: the push that would, and the certificate that what was recorded does not.
//!
//! [`experiment`] looks through parametrised pushes for the one on which two models differ most after either has absorbed
//! what it can; [`certificate`] states in numbers that two fitted models make the same motion of what was recorded.

mod bench;
mod certificate;
mod certified;
mod choose;
mod files;
mod imagine;
mod library;
mod push;
mod rival;
mod sentence;
mod separation;

pub use bench::{Bench, Instruments, Limits};
pub(crate) use certificate::{BLIND, Simulated, of_simulations};
pub use certificate::{Certificate, certificate};
pub(crate) use certified::certified;
pub use files::{Designed, Object, between};
pub(crate) use imagine::Moves;
pub use push::{Profile, Push};
pub use rival::Rival;
pub(crate) use separation::unabsorbed;

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;

use crate::thresholds::MIN_EFFECT_PROBABILITY;
use choose::{LEAST, Ledger, Search, Trial};
use sentence::{rounded, spoken};
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, Normal};
use trundle_infer::{InferError, Watch};

/// A push of an experiment.
#[derive(Clone, Debug, Serialize)]
pub struct Planned {
    /// The push.
    #[serde(flatten)]
    pub push: Push,
    /// Its command: rows `[t, f_x, f_y, τ]`, t in s from contact on, gripper axes.
    pub knots: Vec<[f64; 4]>,
    /// Expected separation by this push alone, mean over which model is true, nats.
    pub separation: f64,
    /// The same with all pushes of the experiment up to this one.
    pub cumulative: f64,
    /// What to do.
    pub sentence: String,
}

/// The pushes that best tell two models apart.
#[derive(Clone, Debug, Serialize)]
pub struct Experiment {
    /// Names of the two models.
    pub models: [String; 2],
    /// What to do, best first; empty where no push tells anything.
    pub pushes: Vec<Planned>,
    /// Expected log-likelihood ratio against the best refit of the other, if the first model is true and if the
    /// second is, nats.
    pub separation: [f64; 2],
    /// By how much the recording already prefers the first, nats (log likelihood).
    pub recorded: f64,
    /// Chance that afterwards the true one has a probability above 0.95, mean over which it is.
    pub sure: f64,
    /// How often the pushes must be made for that chance to be 0.95; none where that is out of reach.
    pub repeats: Option<u32>,
    /// All of it for a person.
    pub sentence: String,
}

/// Nobody repeats an experiment more often.
const MOST_REPEATS: u32 = 50;

/// The `count` pushes, one after the other, that best tell two models apart.
///
/// # Errors
/// When a model cannot be evaluated, or the user interrupts.
pub fn experiment(
    bench: &Bench,
    first: &Rival,
    second: &Rival,
    count: usize,
    watch: &dyn Watch,
) -> Result<Experiment, InferError> {
    let rivals = [first, second];
    let search = Search::new(bench, rivals, watch)?;
    let (mut ledger, mut chosen) = (Ledger::empty(&rivals), Vec::<Trial>::new());
    for k in 0..count {
        watch.progress("designing pushes", k as f64 / count as f64);
        let Some(best) = search.best(&ledger, bench.recorded + k)? else { break };
        ledger = best.ledger.clone();
        chosen.push(best);
    }
    let pushes: Vec<Push> = chosen.iter().map(|t| t.push).collect();
    let separation = if pushes.is_empty() { [0.0; 2] } else { search.refitted(&pushes)? };
    let planned = chosen.iter().map(|t| Planned {
        push: t.push,
        knots: t.push.knots(),
        separation: t.alone,
        cumulative: t.together,
        sentence: spoken(&t.push, bench),
    });
    let recorded = second.cost - first.cost;
    Ok(told([first.name.clone(), second.name.clone()], planned.collect(), separation, recorded))
}

fn told(models: [String; 2], pushes: Vec<Planned>, separation: [f64; 2], recorded: f64) -> Experiment {
    let sure = chance(separation, recorded, 1);
    let mut repeats = (1..=MOST_REPEATS).find(|n| chance(separation, recorded, *n) >= MIN_EFFECT_PROBABILITY);
    if pushes.is_empty() {
        repeats = None;
    }
    let sentence = sentence(&models, &pushes, separation, sure, repeats);
    Experiment { models, pushes, separation, recorded, sure, repeats, sentence }
}

/// The chance that `n` repetitions make the true model surer than [`SURE`], mean over which it is. A log-likelihood
/// ratio with the mean `D` under the truth is normal with the variance `2 D`.
fn chance([first, second]: [f64; 2], recorded: f64, n: u32) -> f64 {
    let needed = (MIN_EFFECT_PROBABILITY / (1.0 - MIN_EFFECT_PROBABILITY)).ln();
    let one = |separation: f64, ahead: f64| {
        let mean = f64::from(n) * separation;
        let spare = ahead + mean - needed;
        Normal::new(0.0, 1.0).map_or(0.0, |normal| normal.cdf(spare / (2.0 * mean).max(1e-9).sqrt()))
    };
    0.5 * (one(first, recorded) + one(second, -recorded))
}

fn sentence(
    [first, second]: &[String; 2],
    pushes: &[Planned],
    separation: [f64; 2],
    sure: f64,
    repeats: Option<u32>,
) -> String {
    if pushes.is_empty() {
        return format!("No push within the limits tells {first} from {second}.");
    }
    let all: Vec<&str> = pushes.iter().map(|p| p.sentence.as_str()).collect();
    let nats = |value: f64| if value > 1000.0 { "over 1000".to_owned() } else { rounded(value) };
    let [a, b] = separation.map(nats);
    let repeats = match repeats {
        Some(1) => String::new(),
        Some(n) => format!("; made {n} times it suffices for 95 %"),
        None => "; repeating it does not suffice".to_owned(),
    };
    format!(
        "{} That parts {first} from {second} by {a} nats if the first is true and {b} if the second is: the right \
         name is then above 0.95 with a chance of {:.0} %{repeats}.",
        all.join(" Then: "),
        100.0 * sure
    )
}

/// Whether an experiment is worth making.
impl Experiment {
    /// Whether its pushes tell the models apart at all.
    pub fn tells(&self) -> bool {
        !self.pushes.is_empty() && self.separation.iter().sum::<f64>() > LEAST
    }
}
