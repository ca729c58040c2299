//! Offset of the tracked frame from the object frame, for example by misplaced markers.
//!
//! The recorded pose is that of a frame at `(offset_x, offset_y, offset_theta)` in the object frame, in which
//! footprint, mass centre, feet and wheels are given:
//!
//! ```text
//! recorded = object ∘ offset
//! ```
//! Laws are evaluated in the object frame and are not affected by the offset. Without feet, a shift is
//! indistinguishable from an offset mass centre, and a rotation from a wheel at another angle.

use super::signed;
use crate::Real;
use crate::law::{EffectLaw, EffectTarget, LawSetup, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "tracker_offset",
    effect: "tracker_offset",
    summary: "offset of the tracked frame from the frame of the footprint",
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
    sentence: "The tracked frame is offset from the frame of the footprint by ({offset_x}, {offset_y}) and rotated by \
        {offset_theta}.",
    suggested_push: "rotate the object about a marked point and compare it with the centre of rotation of the tracked \
        poses",
};

/// Law with its parameters.
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
