//! Viscous friction of a joint whose damping is fixed in the nominal model.

use super::law::{Applies, JointLaw, JointSample, JointScales, Scale, Spec, signed, take};
use crate::units::Unit;
use trundle_model::Real;

pub(super) const SPEC: Spec = Spec {
    effect: "joint_viscous_friction",
    summary: "viscous friction of a joint",
    source: "Armstrong-Hélouvry, Dupont and Canudas de Wit, Automatica 1994",
    applies: Applies::Always,
    params: &[signed("damping", Unit::Damping, Scale::Damping)],
    sentence: "Viscous friction of {damping} is missing in joint {joint}",
    experiment: "move the joint at several constant speeds",
    starts,
};

fn starts(scales: &JointScales) -> Vec<Vec<f64>> {
    vec![vec![0.1 * scales.effort / scales.velocity]]
}

/// The law with values.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Law<T> {
    damping: T,
}

impl<T: Real> JointLaw<T> for Law<T> {
    fn new(values: &[T]) -> Self {
        let [damping] = take(values);
        Self { damping }
    }

    fn effort(&self, at: &JointSample<T>) -> T {
        -(self.damping * at.v)
    }
}
