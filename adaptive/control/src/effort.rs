//! Iterations and plans of a call within the largest number of rollouts.

use crate::Settings;

/// Factor on the spread from one iteration to the next if the number of iterations is that of the settings.
const SPREAD_DECAY: f64 = 0.5;
/// Smallest number of iterations of a call with a limit.
const MIN_ITERATIONS: usize = 3;
/// Smallest number of plans per iteration of a call with a limit.
const MIN_PLANS: usize = 16;

/// Work of a call of the planner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Effort {
    /// Number of iterations.
    pub iterations: usize,
    /// Number of plans per iteration.
    pub plans: usize,
    /// Factor on the spread from one iteration to the next. The last one is that of a call without a limit.
    pub decay: f64,
}

impl Effort {
    /// Work of a call with `models` models. Iterations and plans are reduced by the same factor.
    pub fn of(settings: &Settings, models: usize) -> Self {
        let Settings { iterations, samples, .. } = *settings;
        let wanted = (iterations * samples * models) as f64;
        let excess = settings.rollouts.map_or(1.0, |rollouts| (wanted / rollouts as f64).max(1.0));
        if excess == 1.0 {
            return Self { iterations, plans: samples, decay: SPREAD_DECAY };
        }
        let fewer = (iterations as f64 / excess.sqrt()).round() as usize;
        let fewer = fewer.max(MIN_ITERATIONS.min(iterations));
        let plans = plans_within(settings, fewer * models);
        let decays = |iterations: usize| iterations.saturating_sub(1).max(1) as f64;
        Self { iterations: fewer, plans, decay: SPREAD_DECAY.powf(decays(iterations) / decays(fewer)) }
    }
}

/// Settings with another number of iterations, for several calls that take `rollouts` rollouts per plan together. The limit
/// of the settings applies to the sum of the calls.
pub(crate) fn shared_settings(settings: &Settings, iterations: usize, rollouts: usize) -> Settings {
    let samples = plans_within(settings, iterations * rollouts);
    Settings { iterations, samples, rollouts: None, ..settings.clone() }
}

/// Number of plans per iteration within the limit of the settings, if each takes `rollouts` rollouts in all.
fn plans_within(settings: &Settings, rollouts: usize) -> usize {
    let samples = settings.samples;
    settings.rollouts.map_or(samples, |limit| (limit / rollouts.max(1)).max(MIN_PLANS).min(samples))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn effort(rollouts: Option<usize>, models: usize) -> Effort {
        let settings = Settings { rollouts, ..Settings::within([-1.0; 3], [1.0; 3]) };
        Effort::of(&settings, models)
    }

    #[test]
    fn a_limit_reduces_the_work_of_calls_with_several_models() {
        let full = Effort { iterations: 6, plans: 256, decay: 0.5 };
        assert_eq!([effort(None, 5), effort(Some(1536), 1), effort(Some(10_000), 5)], [full; 3]);
        for (rollouts, models) in [(1536, 5), (1536, 2), (400, 1), (3000, 9), (1000, 3)] {
            let Effort { iterations, plans, decay } = effort(Some(rollouts), models);
            let done = iterations * plans * models;
            assert!(done <= rollouts && 10 * done > 9 * rollouts, "{rollouts} {models}: {done}");
            assert!((3..=6).contains(&iterations));
            assert!((decay.powi(iterations as i32 - 1) - 0.5f64.powi(5)).abs() < 1e-12);
        }
    }
}
