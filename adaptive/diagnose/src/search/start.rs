//! Starting points of the fit of an effect: the Newton step of the score test, and shorter steps.

use crate::fitted_model::{FittedModel, Job};
use crate::linearisation::Start;
use trundle_model::{Effect, Role};

/// Shares of the screen's Newton step from which a fit starts.
const STEP_SHARES: [f64; 2] = [1.0, 0.25];

/// The fit of a kind of effect that is added to a model, from its screened starting points. Shorter steps are
/// tried too, because the Newton step overshoots far from the optimum.
pub(super) fn job(from: &FittedModel, starts: &[Start]) -> Job {
    let mut added = from.added.clone();
    added.extend(starts.first().map(|s| with_free_parameters(&s.effect)));
    let with = |own: &[f64], effect: &Effect| -> Vec<f64> {
        own.iter().copied().chain(effect.values.iter().map(|v| v.unwrap_or(0.0))).collect()
    };
    let mut warm = vec![];
    for start in starts {
        for share in STEP_SHARES {
            let effect = with_step_share(&start.effect, share);
            warm.push(with(&start.base, &effect));
            warm.push(with(&from.fit.values, &effect));
        }
    }
    Job::from(from, added, warm)
}

/// An effect whose amplitudes move only `share` of the way from their neutral values.
fn with_step_share(effect: &Effect, share: f64) -> Effect {
    let spec = effect.kind.spec();
    let mut shorter = effect.clone();
    for (param, value) in spec.params.iter().zip(&mut shorter.values) {
        let neutral = spec.neutral.iter().find(|(name, value)| *name == param.name && value.is_finite());
        if let (Some((_, neutral)), Some(value)) = (neutral, value) {
            *value = neutral + share * (*value - neutral);
        }
    }
    shorter
}

/// An effect with its essential parameters and regions free; choices keep their values.
pub(super) fn with_free_parameters(effect: &Effect) -> Effect {
    let mut free = Effect::free(effect.kind);
    for ((param, value), free) in effect.kind.spec().params.iter().zip(&effect.values).zip(&mut free.values) {
        match param.role {
            Role::Choice => *free = *value,
            Role::Region => *free = None,
            _ => {}
        }
    }
    free
}

#[cfg(test)]
mod tests {
    use super::with_step_share;
    use trundle_model::{Effect, Kind};

    #[test]
    fn a_shorter_step_keeps_the_shape_and_starts_from_neutral() {
        let friction = Effect::free(Kind::CoulombFriction).with("x", Some(0.4)).with("force", Some(8.0));
        let shorter = with_step_share(&friction, 0.25);
        assert_eq!(shorter, friction.clone().with("force", Some(2.0)));
        let gain = Effect::free(Kind::ForceScale).with("gain_y", Some(1.4));
        let value = with_step_share(&gain, 0.25).values.into_iter().flatten().fold(0.0, f64::max);
        assert!((value - 1.1).abs() < 1e-12, "{value}");
    }
}
