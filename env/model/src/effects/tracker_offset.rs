//! A tracked frame that is not where the footprint says: the markers were glued on beside their place.
//!
//! The recorded pose is that of a frame which lies at `(offset_x, offset_y, offset_theta)` in the object frame in
//! which footprint, mass centre, feet and wheels are given:
//!
//! ```text
//! recorded = object ∘ offset
//! ```
//! The body is simulated in its own frame and only its pose is moved, so that every other law stays what it is. On an
//! object without feet a shift cannot be told from a mass centre elsewhere, nor a turn from a wheel at another angle.

use super::signed;
use crate::Real;
use crate::law::{EffectLaw, EffectTarget, LawSetup, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "tracker_offset",
    effect: "tracker_offset",
    summary: "the tracked frame is not where the footprint says",
    source: "recorded pose = object pose ∘ offset, a constant frame on the body",
    target: EffectTarget::Instrument,
    is_dissipative: false,
    changes_mass: false,
    inner_states: &[],
    params: &[
        signed("offset_x", "m", 10.0, 0.05, "origin of the tracked frame, object frame").planar(),
        signed("offset_y", "m", 10.0, 0.05, "origin of the tracked frame, object frame").planar(),
        signed("offset_theta", "rad", 3.2, 0.1, "heading of the tracked frame, object frame").planar(),
    ],
    neutral: &[("offset_x", 0.0), ("offset_y", 0.0), ("offset_theta", 0.0)],
    sentence: "The tracked frame lies at ({offset_x}, {offset_y}), turned by {offset_theta}, where the footprint says it \
               is the object's own.",
    suggested_push: "turn the object on the spot about a point that is marked on it, and look where the tracker says it turns",
};

/// The law in place.
#[derive(Clone, Debug)]
pub struct TrackerOffset<T> {
    offset: [T; 3],
}

impl<T: Real> EffectLaw<T> for TrackerOffset<T> {
    const IS_POSE_INVARIANT: bool = true;

    fn new(values: &[T], _site: &LawSetup<'_, T>) -> Self {
        Self { offset: take(values) }
    }

    #[inline]
    fn mount(&self) -> Option<[T; 3]> {
        Some(self.offset)
    }
}
