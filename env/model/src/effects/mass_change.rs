//! A load that is added or removed at one time, permanently.
//!
//! ```text
//! M → M + mass,   I → I (M + mass)/M   after the event
//! ```
//! The velocity is continuous, and the inertia about the mass centre scales with the mass. The mass centre and the
//! friction of the wheels do not change.

use super::event::{Event, episode, time};
use super::signed;
use crate::Real;
use crate::law::{Clock, EffectLaw, EffectTarget, LawSetup, Rigid, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "mass_change",
    effect: "mass_change",
    summary: "a load is added or removed at one time, permanently; the inertia scales with the mass",
    source: "Newton's second law with a step in mass and continuous velocity",
    target: EffectTarget::Object,
    is_dissipative: false,
    changes_mass: true,
    inner_states: &[],
    params: &[episode(), time(), signed("mass", "kg", 1e4, 10.0, "added mass; negative if it is removed")],
    neutral: &[("mass", 0.0)],
    sentence: "At {time} in {episode} the mass changes permanently by {mass} (negative: a load is removed).",
    suggested_push: "accelerate and stop quickly, in the same way before and after: a load affects acceleration and \
        not motion at constant speed",
};

/// Smallest remaining fraction of the mass: a search may try to remove more than the total.
const MIN_MASS_FRACTION: f64 = 0.02;

/// Law with its parameters.
#[derive(Clone, Debug)]
pub struct MassChange<T> {
    event: Event<T>,
    mass: T,
}

impl<T: Real> EffectLaw<T> for MassChange<T> {
    const IS_POSE_INVARIANT: bool = true;

    fn new(values: &[T], _site: &LawSetup<'_, T>) -> Self {
        let [episode, time, mass] = take(values);
        Self { event: Event::new(episode, time), mass }
    }

    #[inline]
    fn change_mass(&self, clock: Clock, _grasp: [f64; 2], rigid: &mut Rigid<T>) {
        let left =
            (self.event.fraction_after(clock) * self.mass / rigid.mass + 1.0).max(T::lift(MIN_MASS_FRACTION));
        rigid.mass = rigid.mass * left;
        rigid.inertia = rigid.inertia * left;
    }
}
