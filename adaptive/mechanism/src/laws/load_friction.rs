//! Dry friction that grows with the effort that the gear transmits, or with a recorded covariate.

use super::law::{
    Applies, JointLaw, JointSample, JointScales, ParamSpec, Scale, Spec, magnitude, positive, take,
};
use crate::units::Unit;
use trundle_model::Real;

pub(super) const SPEC: Spec = Spec {
    effect: "joint_load_friction",
    summary: "dry friction that grows with the transmitted effort",
    source: "Duclusaud et al., BAM, arXiv 2410.08650",
    applies: Applies::Loaded,
    params: &[ParamSpec { bounds: [0.0, 0.9], ..positive("coefficient", Unit::One, Scale::PerLoad) }],
    sentence: "Dry friction in joint {joint} grows with the load: {coefficient} per unit",
    experiment: "repeat the motion with another load on the joint",
    starts,
};

fn starts(scales: &JointScales) -> Vec<Vec<f64>> {
    vec![vec![0.1 * Scale::PerLoad.of(scales)]]
}

/// The law with values.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Law<T> {
    coefficient: T,
}

impl<T: Real> JointLaw<T> for Law<T> {
    fn new(values: &[T]) -> Self {
        let [coefficient] = take(values);
        Self { coefficient }
    }

    fn dry_friction(&self, at: &JointSample<T>) -> T {
        match (at.load, at.drive) {
            (Some(load), _) => self.coefficient * load.abs(),
            (None, Some(drive)) => self.coefficient * magnitude(drive - at.external),
            (None, None) => T::zero(),
        }
    }

    fn reads_external(&self) -> bool {
        true
    }

    fn response(&self, at: &JointSample<T>, _largest: f64) -> Option<T> {
        if at.load.is_some() {
            return None;
        }
        at.drive.map(|drive| {
            let side = (drive - at.external).re().signum() * at.v.signum();
            -(self.coefficient * side) + 1.0
        })
    }
}
