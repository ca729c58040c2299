//! Dry friction that opposes the velocity and holds the joint at rest, with the Stribeck curve.

use super::law::{Applies, JointLaw, JointSample, JointScales, ParamSpec, Scale, Spec, positive, take};
use crate::units::Unit;
use trundle_model::Real;

/// Transition velocity of the Stribeck curve, in rms velocities of the joint: slower motion counts as rest, and a slower fall of the
/// friction is a negative damping.
const TRANSITION: [f64; 2] = [0.1, 1.0];

pub(super) const SPEC: Spec = Spec {
    effect: "joint_dry_friction",
    summary: "dry friction of a joint, with stiction and Stribeck curve",
    source: "Armstrong-Hélouvry, Dupont and Canudas de Wit, Automatica 1994",
    applies: Applies::Always,
    params: &[
        positive("effort", Unit::Effort, Scale::Effort),
        ParamSpec { refines: true, ..positive("static_effort", Unit::Effort, Scale::Effort) },
        ParamSpec {
            refines: true,
            bounds: TRANSITION,
            ..positive("velocity", Unit::Velocity, Scale::Velocity)
        },
    ],
    sentence: "Dry friction of {effort}[, {static_effort} at rest,] acts in joint {joint}",
    experiment: "move the joint slowly in both directions, with constant speeds and reversals",
    starts,
};

fn starts(scales: &JointScales) -> Vec<Vec<f64>> {
    vec![vec![0.1 * scales.effort, f64::NAN, f64::NAN]]
}

/// The law with values.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Law<T> {
    effort: T,
    /// Excess of the friction at rest, and the velocity at which it has fallen.
    stribeck: Option<(T, T)>,
}

impl<T: Real> JointLaw<T> for Law<T> {
    fn new(values: &[T]) -> Self {
        let [effort, at_rest, velocity] = take(values);
        let is_curve = !at_rest.re().is_nan() && velocity.re() > 0.0;
        Self { effort, stribeck: is_curve.then(|| (at_rest - effort, velocity)) }
    }

    fn dry_friction(&self, at: &JointSample<T>) -> T {
        match self.stribeck {
            Some((excess, velocity)) => self.effort + excess * (-(velocity.recip() * at.v).squared()).exp(),
            None => self.effort,
        }
    }
}
