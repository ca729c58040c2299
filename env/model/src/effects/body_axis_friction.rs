//! Dry friction along axes that are fixed in the body: a slide on the object, joints that turn with it.
//!
//! ```text
//! F_k = −f_k (v·n_k)/√((v·n_k)² + ε²),   n_1 = (cos angle, sin angle) in the body, n_2 across it
//! τ   = −T ω/√(ω² + ε²/ρ²),              v: velocity of the object origin, ρ: radius of gyration
//! ```

use super::axes::{Axes, direction, force_x, force_y, torque};
use super::dry::creep;
use crate::Real;
use crate::law::{Act, Acting, Action, Site, Situation, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "body_axis_friction",
    effect: "axis_friction",
    summary: "dry friction along axes fixed in the body, each with its own force",
    source: "Armstrong-Hélouvry, Dupont, Canudas de Wit 1994, Coulomb friction of each axis",
    acting: Acting::Object,
    dissipative: true,
    loads: false,
    inner: &[],
    params: &[direction("the first axis, object frame"), force_x(), force_y(), torque(), creep()],
    neutral: &[("force_x", 0.0), ("force_y", 0.0), ("torque", 0.0)],
    sentence: "Dry friction acts along axes fixed in the body: {force_x} along {angle}, {force_y} across it and {torque} \
               against turning.",
    probe: "turn the object by an eighth and repeat a push along one axis: axes in the body turn with it, axes in the \
            world do not",
};

/// The law in place.
#[derive(Clone, Debug)]
pub struct BodyAxisFriction<T> {
    /// Direction of the first axis, object frame.
    normal: [T; 2],
    axes: Axes<T>,
}

impl<T: Real> Act<T> for BodyAxisFriction<T> {
    const SAME_EVERYWHERE: bool = true;

    fn new(values: &[T], site: &Site<'_, T>) -> Self {
        let [angle, force_x, force_y, torque, creep] = take(values);
        let (sin, cos) = angle.sin_cos();
        Self { normal: [cos, sin], axes: Axes::new([force_x, force_y], torque, creep, site.body.gyration) }
    }

    #[inline]
    fn act(&self, at: &Situation<'_, T>, sum: &mut Action<T>) {
        self.axes.brake(self.normal, at.twist, sum);
    }
}
