//! A wheel whose friction changes at one moment, for good: it locks, comes free, or rolls onto another floor.
//!
//! ```text
//! F = −R diag((a_x − 1) μ_x, (a_y − 1) μ_y) Rᵀ v(w)   beside the wheel's own, after the event
//! ```
//! The wheel is the model's first [`super::viscous_wheel`]; together they resist with `a μ ≥ 0`.

use super::event::{Event, episode, time};
use super::positive;
use super::viscous_wheel::wheel_drag;
use crate::Real;
use crate::law::{Act, Acting, Action, Param, Site, Situation, Spec, take};

/// A factor, a priori between a fiftieth and fifty.
const fn factor(name: &'static str, help: &'static str) -> Param {
    positive(name, "1", 1e6, (1.0, 2.0), help).any_of()
}

pub(crate) static SPEC: Spec = Spec {
    kind: "wheel_event",
    effect: "wheel_event",
    summary: "at one moment the wheel's friction changes, for good: it locks or comes free",
    source: "Scholz et al., eq. 1-2, with friction that changes once",
    acting: Acting::Object,
    dissipative: true,
    loads: false,
    inner: &[],
    params: &[
        episode(),
        time(),
        factor("factor_x", "friction along the rolling direction, after over before"),
        factor("factor_y", "friction across it, after over before").planar(),
    ],
    neutral: &[("factor_x", 1.0), ("factor_y", 1.0)],
    sentence: "At {time} of the episode the wheel's friction changes for good: along its rolling direction to {factor_x}, \
               across it to {factor_y} times what it was.",
    probe: "push at constant speed along and across the wheel's rolling direction, the same way before and after",
};

/// The law in place: the drag that is added once it has happened.
#[derive(Clone, Debug)]
pub struct WheelEvent<T> {
    event: Event<T>,
    drag: Action<T>,
}

impl<T: Real> Act<T> for WheelEvent<T> {
    const SAME_EVERYWHERE: bool = true;

    fn new(values: &[T], site: &Site<'_, T>) -> Self {
        let [episode, time, along, across] = take(values);
        let changed = |[x, y, angle, mu_x, mu_y]: [T; 5]| {
            wheel_drag([x, y, angle, (along - 1.0) * mu_x, (across - 1.0) * mu_y])
        };
        let drag = site.wheel.map_or_else(Action::none, changed);
        Self { event: Event::new(episode, time), drag }
    }

    #[inline]
    fn act(&self, at: &Situation<'_, T>, sum: &mut Action<T>) {
        let share = self.event.share(at.clock);
        for (sum, term) in sum.drag.iter_mut().zip(&self.drag.drag) {
            *sum += *term * share;
        }
    }
}
