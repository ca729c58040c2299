//! Delay of the reading: reading(t) = truth(t - delay).

use super::law::{Applies, JointLaw, JointScales, Scale, Spec, signed, take};
use crate::units::Unit;
use trundle_model::Real;

pub(super) const SPEC: Spec = Spec {
    effect: "effort_delay",
    summary: "delay of the effort reading",
    source: "clock offsets between devices; Furgale, Rehder and Siegwart, IROS 2013",
    applies: Applies::MeasuredEffort,
    params: &[signed("delay", Unit::Time, Scale::Time)],
    sentence: "The effort of joint {joint} is recorded {delay} late\
        |The effort of joint {joint} acts {delay} after it is recorded",
    experiment: "move the joint with fast reversals at two frequencies",
    starts,
};

fn starts(scales: &JointScales) -> Vec<Vec<f64>> {
    vec![vec![0.25 * scales.resolution]]
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
        Some(-self.delay)
    }
}
