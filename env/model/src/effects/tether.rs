//! A cable or spring between a point of the body and a fixed point: a power cord, a hose, a bungee.
//!
//! ```text
//! F = k s(ℓ − ℓ₀) + c s'(ℓ − ℓ₀) ℓ̇   towards the anchor;   ℓ: distance of the two points
//! ```
//! `s` is the positive part, smoothed over a millimetre: below its rest length the cable is slack. It acts after
//! contact; before contact the object is held at rest.

use super::geometry::{in_world, softplus};
use super::{on_body, positive};
use crate::Real;
use crate::generalised_force::GeneralisedForce;
use crate::law::{EffectLaw, EffectTarget, LawContext, LawSetup, Role, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "tether",
    effect: "tether",
    summary: "a cable or spring to a fixed point, slack below its rest length",
    source: "Hooke's law for a unilateral spring, as in a MuJoCo tendon with a dead band",
    target: EffectTarget::Object,
    is_dissipative: false,
    changes_mass: false,
    inner_states: &[],
    params: &[
        on_body("x", 0, "attachment point on the body, object frame"),
        on_body("y", 1, "attachment point on the body, object frame"),
        in_world("anchor_x", 0, "anchor point, world"),
        in_world("anchor_y", 1, "anchor point, world").planar(),
        positive("stiffness", "N/m", 1e5, (100.0, 1.0), "force per extension"),
        positive("rest_length", "m", 100.0, (0.6, 0.8), "length below which it is slack").role(Role::Region),
        positive("damping", "N·s/m", 1e4, (1.0, 1.5), "damping while it is taut")
            .role(Role::Shape)
            .refinement(0.0),
    ],
    neutral: &[("stiffness", 0.0)],
    sentence: "A cable or spring of stiffness {stiffness} connects the body at ({x}, {y}) to ({anchor_x}, {anchor_y}); \
        it is slack below a length of {rest_length}.",
    suggested_push: "pull away from the anchor in two directions and release: a spring pulls back, friction does not",
};

/// Length over which the onset of tension is smoothed, m.
const SMOOTHING_LENGTH_M: f64 = 1e-3;

/// Law with its parameters.
#[derive(Clone, Debug)]
pub struct Tether<T> {
    point: [T; 2],
    anchor: [T; 2],
    stiffness: T,
    rest: T,
    damping: T,
}

impl<T: Real> EffectLaw<T> for Tether<T> {
    fn new(values: &[T], _site: &LawSetup<'_, T>) -> Self {
        let [x, y, ax, ay, stiffness, rest, damping] = take(values);
        Self { point: [x, y], anchor: [ax, ay], stiffness, rest, damping }
    }

    #[inline]
    fn add_force(&self, at: &LawContext<'_, T>, sum: &mut GeneralisedForce<T>) {
        if !at.clock.in_contact() {
            return;
        }
        let [dx, dy] = at.in_object(self.anchor);
        let (dx, dy) = (dx - self.point[0], dy - self.point[1]);
        // The offset of 0.01 mm keeps derivatives of the direction finite if the two points coincide.
        let length = (dx.squared() + dy.squared() + 1e-10).sqrt();
        let (nx, ny) = (dx / length, dy / length);
        let (stretch, taut) = softplus(length - self.rest, SMOOTHING_LENGTH_M);
        let pull = self.stiffness * stretch;
        sum.add_force_at(self.point, [nx * pull, ny * pull]);
        let c = self.damping * taut;
        sum.add_damping_at(self.point, [c * nx * nx, c * nx * ny, c * ny * ny]);
    }
}
