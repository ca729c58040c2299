//! Wrong gain of the effort: reading = gain · truth.

use super::law::{Applies, JointLaw, JointScales, ParamSpec, Scale, Spec, positive, take};
use crate::units::Unit;
use trundle_model::Real;

pub(super) const SPEC: Spec = Spec {
    effect: "effort_gain",
    summary: "wrong gain of the effort",
    source: "calibration of force sensors",
    applies: Applies::MeasuredEffort,
    params: &[ParamSpec { bounds: [0.05, 20.0], ..positive("gain", Unit::One, Scale::One) }],
    sentence: "The effort of joint {joint} is recorded with a gain of {gain}",
    experiment: "hang a known weight on the joint",
    starts,
};

fn starts(scales: &JointScales) -> Vec<Vec<f64>> {
    let _ = scales;
    vec![vec![1.0]]
}

/// The law with values.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Law<T> {
    gain: T,
}

impl<T: Real> JointLaw<T> for Law<T> {
    fn new(values: &[T]) -> Self {
        let [gain] = take(values);
        Self { gain }
    }

    fn correct(&self, reading: T) -> T {
        reading / self.gain
    }

    fn reading_gain(&self) -> Option<T> {
        Some(self.gain)
    }
}
