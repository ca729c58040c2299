//! Compliance between drive and joint.

use super::law::{Applies, Compliance, JointLaw, JointScales, ParamSpec, Scale, Spec, positive, take};
use crate::units::Unit;
use trundle_model::Real;

pub(super) const SPEC: Spec = Spec {
    effect: "joint_elasticity",
    summary: "compliance between drive and joint",
    source: "Spong, J. Dyn. Syst. Meas. Control 1987",
    applies: Applies::Driven,
    params: &[
        ParamSpec {
            bounds: [10.0, f64::INFINITY],
            ..positive("stiffness", Unit::Stiffness, Scale::Stiffness)
        },
        ParamSpec { refines: true, ..positive("damping", Unit::Damping, Scale::Damping) },
    ],
    sentence: "The transmission of joint {joint} has a stiffness of {stiffness}",
    experiment: "excite the joint near its resonance, and hold it under different loads",
    starts,
};

fn starts(scales: &JointScales) -> Vec<Vec<f64>> {
    vec![
        vec![30.0 * scales.effort / scales.span(), f64::NAN],
        vec![300.0 * scales.effort / scales.span(), f64::NAN],
    ]
}

/// The law with values.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Law<T> {
    per_effort: T,
    per_effort_rate: T,
}

impl<T: Real> JointLaw<T> for Law<T> {
    fn new(values: &[T]) -> Self {
        let [stiffness, damping] = take::<T, 2>(values);
        let per_effort = stiffness.recip();
        let damped = !damping.re().is_nan();
        let per_effort_rate = if damped { damping * per_effort.squared() } else { T::zero() };
        Self { per_effort, per_effort_rate }
    }

    fn compliance(&self) -> Option<Compliance<T>> {
        let Self { per_effort, per_effort_rate } = *self;
        Some(Compliance { per_effort, per_effort_rate })
    }
}
