//! A wheel whose friction changes at one time, permanently: it locks, comes free, or rolls onto another floor.
//!
//! ```text
//! F = −R diag((a_x − 1) μ_x, (a_y − 1) μ_y) Rᵀ v(w)   in addition to the wheel's own, after the event
//! ```
//! The wheel is the first [`super::viscous_wheel`] of the model. After the event the total friction is `a μ ≥ 0`.

use super::event::{Event, episode, time};
use super::positive;
use super::viscous_wheel::wheel_damping;
use crate::Real;
use crate::generalised_force::GeneralisedForce;
use crate::law::{EffectLaw, EffectTarget, LawContext, LawSetup, Param, Spec, take};

/// A factor with a prior range of about 1/50 to 50.
const fn factor(name: &'static str, help: &'static str) -> Param {
    positive(name, "1", 1e6, (1.0, 2.0), help).alternative()
}

pub(crate) static SPEC: Spec = Spec {
    kind: "wheel_event",
    effect: "wheel_event",
    summary: "the friction of the wheel changes at one time, permanently: it locks or comes free",
    source: "Scholz et al., eq. 1-2, with a step change of friction",
    target: EffectTarget::Object,
    is_dissipative: true,
    changes_mass: false,
    inner_states: &[],
    params: &[
        episode(),
        time(),
        factor("factor_x", "ratio of friction along the rolling direction after and before the event"),
        factor("factor_y", "ratio of friction across the rolling direction after and before the event")
            .planar(),
    ],
    neutral: &[("factor_x", 1.0), ("factor_y", 1.0)],
    sentence: "At {time} in {episode} the friction of the wheel changes permanently by the factors {factor_x} along \
        and {factor_y} across its rolling direction.",
    suggested_push: "push at constant speed along and across the rolling direction of the wheel, in the same way \
        before and after",
};

/// Law with its parameters: the damping that is added after the event.
#[derive(Clone, Debug)]
pub struct WheelEvent<T> {
    event: Event<T>,
    damping: GeneralisedForce<T>,
}

impl<T: Real> EffectLaw<T> for WheelEvent<T> {
    const IS_POSE_INVARIANT: bool = true;

    fn new(values: &[T], site: &LawSetup<'_, T>) -> Self {
        let [episode, time, along, across] = take(values);
        let changed = |[x, y, angle, mu_x, mu_y]: [T; 5]| {
            wheel_damping([x, y, angle, (along - 1.0) * mu_x, (across - 1.0) * mu_y])
        };
        let damping = site.wheel.map_or_else(GeneralisedForce::zero, changed);
        Self { event: Event::new(episode, time), damping }
    }

    #[inline]
    fn add_force(&self, at: &LawContext<'_, T>, sum: &mut GeneralisedForce<T>) {
        let share = self.event.fraction_after(at.clock);
        for (sum, term) in sum.damping.iter_mut().zip(&self.damping.damping) {
            *sum += *term * share;
        }
    }
}
