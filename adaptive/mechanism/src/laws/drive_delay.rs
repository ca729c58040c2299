//! Delay of the drive behind its command.

use super::law::{Applies, JointLaw, JointScales, Scale, Spec, positive, take};
use crate::units::Unit;
use trundle_model::Real;

pub(super) const SPEC: Spec = Spec {
    effect: "drive_delay",
    summary: "delay of the drive",
    source: "communication and control delays",
    applies: Applies::CommandedEffort,
    params: &[positive("delay", Unit::Time, Scale::Time)],
    sentence: "The drive of joint {joint} acts {delay} after its command",
    experiment: "command steps and fast reversals",
    starts,
};

fn starts(scales: &JointScales) -> Vec<Vec<f64>> {
    vec![vec![0.25 * scales.resolution], vec![2.0 * scales.resolution]]
}

/// The law with values.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Law<T> {
    delay: T,
}

impl<T: Real> JointLaw<T> for Law<T> {
    fn new(values: &[T]) -> Self {
        let [delay] = take(values);
        Self { delay }
    }

    fn delay(&self) -> Option<T> {
        Some(self.delay)
    }
}
