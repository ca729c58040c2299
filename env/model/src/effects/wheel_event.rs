//! A wheel whose friction changes at one moment, for good: it locks, comes free, or rolls onto another floor.
//!
//! ```text
//! F = −R diag((a_x − 1) μ_x, (a_y − 1) μ_y) Rᵀ v(w)   beside the wheel's own, after the event
//! ```
//! The wheel is the model's first [`super::viscous_wheel`]; together they resist with `a μ ≥ 0`.

use super::event::{Event, episode, time};
use super::positive;
use super::viscous_wheel::wheel_damping;
use crate::Real;
use crate::law::{EffectLaw, EffectTarget, GeneralisedForce, LawContext, LawSetup, Param, Spec, take};

/// A factor, a priori between a fiftieth and fifty.
const fn factor(name: &'static str, help: &'static str) -> Param {
    positive(name, "1", 1e6, (1.0, 2.0), help).alternative()
}

pub(crate) static SPEC: Spec = Spec {
    kind: "wheel_event",
    effect: "wheel_event",
    summary: "at one moment the wheel's friction changes, for good: it locks or comes free",
    source: "Scholz et al., eq. 1-2, with friction that changes once",
    target: EffectTarget::Object,
    is_dissipative: true,
    changes_mass: false,
    inner_states: &[],
    params: &[
        episode(),
        time(),
        factor("factor_x", "friction along the rolling direction, after over before"),
        factor("factor_y", "friction across it, after over before").planar(),
    ],
    neutral: &[("factor_x", 1.0), ("factor_y", 1.0)],
    sentence: "At {time} of the episode the wheel's friction changes for good: along its rolling direction to {factor_x}, \
               across it to {factor_y} times what it was.",
    suggested_push: "push at constant speed along and across the wheel's rolling direction, the same way before and after",
};

/// The law in place: the damping that is added once it has happened.
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
