//! Friction that differs by direction.

use super::law::{Applies, JointLaw, JointSample, JointScales, ParamSpec, Scale, Spec, signed, take};
use crate::units::Unit;
use trundle_model::Real;

pub(super) const SPEC: Spec = Spec {
    effect: "joint_directional_friction",
    summary: "friction that differs by direction",
    source: "Kermani, Patel and Moallem, IEEE Trans. Control Syst. Technol. 2007",
    applies: Applies::Always,
    params: &[
        ParamSpec { refines: true, ..signed("viscous_difference", Unit::Damping, Scale::Damping) },
        signed("dry_difference", Unit::Effort, Scale::Effort),
    ],
    sentence: "Friction in joint {joint} differs by direction: half the difference is {dry_difference}[, and {viscous_difference} in its damping]",
    experiment: "move the joint with several constant speeds in both directions; measure the effort at rest to exclude an offset of the effort",
    starts,
};

fn starts(scales: &JointScales) -> Vec<Vec<f64>> {
    vec![vec![f64::NAN, 0.02 * scales.effort], vec![0.05 * scales.effort / scales.velocity, 0.0]]
}

/// The law with values.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Law<T> {
    viscous: T,
    dry: T,
}

impl<T: Real> JointLaw<T> for Law<T> {
    fn new(values: &[T]) -> Self {
        let [viscous, dry] = take(values);
        Self { viscous: if viscous.re().is_nan() { T::zero() } else { viscous }, dry }
    }

    fn effort(&self, at: &JointSample<T>) -> T {
        -(self.viscous * at.v.abs()) - self.dry
    }
}
