//! Limit of the effort of a drive.

use super::law::{Applies, JointLaw, JointScales, ParamSpec, Scale, Spec, magnitude, positive, take};
use crate::units::Unit;
use trundle_model::Real;

pub(super) const SPEC: Spec = Spec {
    effect: "effort_saturation",
    summary: "limit of the effort of a drive",
    source: "current limit of drives",
    applies: Applies::CommandedEffort,
    params: &[ParamSpec { is_limit: true, ..positive("limit", Unit::Effort, Scale::Effort) }],
    sentence: "The drive of joint {joint} delivers no more than {limit}",
    experiment: "command the largest effort against a known load",
    starts,
};

fn starts(scales: &JointScales) -> Vec<Vec<f64>> {
    [2.5, 1.5, 1.0, 0.5, 0.2, 0.07].iter().map(|share| vec![share * scales.effort]).collect()
}

/// The law with values.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Law<T> {
    limit: T,
}

impl<T: Real> JointLaw<T> for Law<T> {
    fn new(values: &[T]) -> Self {
        let [limit] = take(values);
        Self { limit }
    }

    fn clips(&self) -> bool {
        true
    }

    fn drive(&self, command: T, _largest: f64) -> T {
        if magnitude(command).re() <= self.limit.re() {
            command
        } else if command.re() > 0.0 {
            self.limit
        } else {
            -self.limit
        }
    }
}
