//! Doubts that a careful reader must know. Held-out episodes change no verdict, only warnings.

use crate::error_metrics::EpisodeErrors;
use crate::fit::Fit;
use crate::model::{Nominal, Role};
use crate::problem::Problem;
use crate::units::EffortUnit;
use trundle_diagnose::{ErrorMetric, unlike_training, worse_metrics};

/// Ratio of a refitted mass to the model's that is implausible.
const MAX_MASS_RATIO: f64 = 2.0;

/// Warnings about the fitted values.
pub(crate) fn warnings(problem: &Problem, fitted: &Fit) -> Vec<String> {
    let mut found = vec![];
    match problem.effort_unit {
        EffortUnit::Newton => {}
        EffortUnit::PerInertia => found.push(
            "nothing fixes the scale of force: all dynamics are per unit of inertia, in 1/s and 1/s²".to_owned(),
        ),
        EffortUnit::Recorded => found.push(
            "nothing fixes the scale of force: efforts are in the recorded unit, inertias in that unit per acceleration"
                .to_owned(),
        ),
        EffortUnit::TargetError => found.push(
            "nothing fixes the scale of force: efforts are in position error of the target".to_owned(),
        ),
    }
    for (slot, value) in fitted.slots.iter().zip(&fitted.values) {
        if let Role::Nominal(Nominal::Mass(body)) = slot.role {
            let ratio = value / problem.bodies[body].1;
            if !(MAX_MASS_RATIO.recip()..=MAX_MASS_RATIO).contains(&ratio) {
                found.push(format!("{}: the refitted mass is {ratio:.2} times the model's", slot.name));
            }
        }
    }
    found
}

/// Warnings about held-out episodes: those that behave unlike the training episodes, and `metrics` that became worse.
pub(crate) fn held_out_warnings(errors: &[EpisodeErrors], metrics: &[ErrorMetric]) -> Vec<String> {
    let mut found = vec![];
    for episode in errors.iter().filter(|episode| episode.held_out) {
        let largest = |joint: &str, floor: f64| {
            let training = errors.iter().filter(|other| !other.held_out);
            training.filter_map(|other| other.joints.get(joint)).fold(floor, |most, own| most.max(own.rms))
        };
        let unlike = episode.joints.iter().map(|(joint, own)| (joint, own.rms, largest(joint, own.floor)));
        let worst = unlike.max_by(|a, b| (a.1 / a.2).total_cmp(&(b.1 / b.2)));
        found.extend(worst.and_then(|(joint, error, largest)| {
            let metric = format!("error of the effort of joint {joint}");
            let cause = "the mechanism, its load or its drives";
            unlike_training(&episode.name, &metric, error, largest, cause)
        }));
    }
    found.extend(worse_metrics(metrics));
    found
}

#[cfg(test)]
mod tests {
    use super::held_out_warnings;
    use crate::error_metrics::{EpisodeErrors, ResidualSize};

    #[test]
    fn a_held_out_episode_with_larger_errors_is_reported() {
        let episode = |name: &str, held_out: bool, rms: f64| EpisodeErrors {
            name: name.to_owned(),
            held_out,
            joints: [("elbow".to_owned(), ResidualSize { rms, floor: 0.1 })].into(),
        };
        let of =
            |error: f64| held_out_warnings(&[episode("one", false, 0.2), episode("two", true, error)], &[]);
        assert!(of(0.5).is_empty());
        let found = of(0.8);
        assert!(found[0].contains("two (held out)") && found[0].contains("elbow is 4.0 times"), "{found:?}");
        // Errors within the noise are alike.
        assert!(held_out_warnings(&[episode("one", false, 0.01), episode("two", true, 0.2)], &[]).is_empty());
    }
}
