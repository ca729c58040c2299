//! Inertia of the rotor seen at the joint, if the armature is fixed in the nominal model.

use super::law::{Applies, JointLaw, JointSample, JointScales, Scale, Spec, positive, take};
use crate::units::Unit;
use trundle_model::Real;

pub(super) const SPEC: Spec = Spec {
    effect: "rotor_inertia",
    summary: "inertia of the rotor at the joint",
    source: "Featherstone, Rigid Body Dynamics Algorithms, 2008",
    applies: Applies::Always,
    params: &[positive("armature", Unit::Inertia, Scale::Inertia)],
    sentence: "An inertia of {armature} is missing at joint {joint}",
    experiment: "accelerate the joint strongly, with fast reversals",
    starts,
};

fn starts(scales: &JointScales) -> Vec<Vec<f64>> {
    vec![vec![0.1 * scales.effort / scales.acceleration]]
}

/// The law with values.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Law<T> {
    armature: T,
}

impl<T: Real> JointLaw<T> for Law<T> {
    fn new(values: &[T]) -> Self {
        let [armature] = take(values);
        Self { armature }
    }

    fn effort(&self, at: &JointSample<T>) -> T {
        -(self.armature * at.a)
    }
}
