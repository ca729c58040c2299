//! Compliance between drive and joint.

use super::law::{
    Applies, Compliance, DAMPING_RATIO, JointLaw, JointScales, ParamSpec, Scale, Spec, positive, take,
};
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
    // Where the resonance is among the recorded frequencies, a fit has several optima, and the damping matters.
    let stiffness = [30.0, 100.0, 300.0, 1000.0].map(|factor| factor * scales.effort / scales.span());
    let damping = |stiffness: f64| 2.0 * DAMPING_RATIO * (stiffness * Scale::Inertia.of(scales)).sqrt();
    stiffness.iter().flat_map(|k| [vec![*k, f64::NAN], vec![*k, damping(*k)]]).collect()
}

/// The law with values.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Law<T> {
    stiffness: T,
    damping: Option<T>,
}

impl<T: Real> JointLaw<T> for Law<T> {
    fn new(values: &[T]) -> Self {
        let [stiffness, damping] = take::<T, 2>(values);
        Self { stiffness, damping: Some(damping).filter(|damping| !damping.re().is_nan()) }
    }

    fn compliance(&self) -> Option<Compliance<T>> {
        let Self { stiffness, damping } = *self;
        Some(Compliance { stiffness, damping })
    }
}
