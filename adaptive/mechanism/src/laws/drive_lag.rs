//! First-order lag of the drive behind its command.

use super::law::{Applies, JointLaw, JointScales, Scale, Spec, positive, take};
use crate::units::Unit;
use trundle_model::Real;

pub(super) const SPEC: Spec = Spec {
    effect: "drive_lag",
    summary: "first-order lag of the drive",
    source: "first-order low-pass filter",
    applies: Applies::CommandedEffort,
    params: &[positive("time_constant", Unit::Time, Scale::Time)],
    sentence: "The drive of joint {joint} lags behind its command by {time_constant}",
    experiment: "command steps and fast reversals",
    starts,
};

fn starts(scales: &JointScales) -> Vec<Vec<f64>> {
    vec![vec![0.25 * scales.resolution], vec![2.0 * scales.resolution]]
}

/// The law with values.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Law<T> {
    time_constant: T,
}

impl<T: Real> JointLaw<T> for Law<T> {
    fn new(values: &[T]) -> Self {
        let [time_constant] = take(values);
        Self { time_constant }
    }

    fn lag(&self) -> Option<T> {
        Some(self.time_constant)
    }
}
