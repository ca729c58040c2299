//! Dry friction at one point of the body: a dragging foot, a jammed caster.
//!
//! ```text
//! F = −f(|v|) v / √(|v|² + ε²),   v: velocity of the point
//! ```

use super::dry::{Dry, creep, static_force, stribeck_velocity};
use super::{on_body, positive};
use crate::Real;
use crate::law::{Act, Acting, Action, Site, Situation, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "coulomb_friction",
    effect: "coulomb_friction",
    summary: "dry friction at a point: stiction, sliding, Stribeck",
    source: "Armstrong-Hélouvry, Dupont, Canudas de Wit 1994",
    acting: Acting::Object,
    dissipative: true,
    loads: false,
    inner: &[],
    params: &[
        on_body("x", 0, "where it rubs, object frame"),
        on_body("y", 1, "where it rubs, object frame"),
        positive("force", "N", 1e5, (10.0, 1.5), "sliding friction"),
        static_force(),
        stribeck_velocity(),
        creep(),
    ],
    neutral: &[("force", 0.0)],
    sentence: "Dry friction of {force} acts at ({x}, {y}).",
    probe: "repeat one push slowly and fast: dry friction keeps its size, viscous friction grows with speed; turn the object both ways to find the point",
};

/// The law in place.
#[derive(Clone, Debug)]
pub struct CoulombFriction<T> {
    point: [T; 2],
    dry: Dry<T>,
}

impl<T: Real> Act<T> for CoulombFriction<T> {
    const SAME_EVERYWHERE: bool = true;

    fn new(values: &[T], _site: &Site<'_, T>) -> Self {
        let [x, y, force, static_force, stribeck, creep] = take(values);
        Self { point: [x, y], dry: Dry { force, static_force, stribeck, creep } }
    }

    #[inline]
    fn act(&self, at: &Situation<'_, T>, sum: &mut Action<T>) {
        let c = self.dry.coefficient(at.velocity(self.point));
        sum.brake_at(self.point, c);
    }
}
