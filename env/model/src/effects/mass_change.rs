//! Load that is put on or taken off at one moment, for good.
//!
//! Velocity is kept, the inertia about the mass centre scales with the mass, the mass centre stays, and so do the
//! wheels: what they resist with does not follow the load.

use super::event::{Event, episode, time};
use super::signed;
use crate::Real;
use crate::law::{Clock, EffectLaw, EffectTarget, LawSetup, Rigid, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "mass_change",
    effect: "mass_change",
    summary: "at one moment load is put on or taken off, for good; velocity is kept, inertia scales with mass",
    source: "Newton's second law with a mass that jumps while the velocity stays",
    target: EffectTarget::Object,
    is_dissipative: false,
    changes_mass: true,
    inner_states: &[],
    params: &[episode(), time(), signed("mass", "kg", 1e4, 5.0, "put on; taken off where it is negative")],
    neutral: &[("mass", 0.0)],
    sentence: "At {time} of the episode, {mass} of load is put on (taken off where negative), for good.",
    suggested_push: "push fast and stop fast, the same way before and after: a load shows where the object speeds up and \
            not at constant speed",
};

/// Share of the mass that is left at least: a search may try to take off more than there is.
const MIN_MASS_FRACTION: f64 = 0.02;

/// The law in place.
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
