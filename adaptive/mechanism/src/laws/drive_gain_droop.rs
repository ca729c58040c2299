//! Effort per unit of command that falls with the size of the command.

use super::law::{
    Applies, JointLaw, JointSample, JointScales, ParamSpec, Scale, Spec, magnitude, signed, take,
};
use crate::units::Unit;
use trundle_model::Real;

pub(super) const SPEC: Spec = Spec {
    effect: "drive_gain_droop",
    summary: "effort per command that falls with its size",
    source: "magnetic saturation of motors; Krishnan, 2001",
    applies: Applies::CommandedEffort,
    params: &[ParamSpec { bounds: [-1.0, 0.5], ..signed("droop", Unit::One, Scale::One) }],
    sentence: "The effort of joint {joint} per unit of command falls by {droop} at the largest command",
    experiment: "command the drive with small and large efforts under known loads",
    starts,
};

fn starts(scales: &JointScales) -> Vec<Vec<f64>> {
    let _ = scales;
    vec![vec![0.1]]
}

/// The law with values.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Law<T> {
    droop: T,
}

impl<T: Real> JointLaw<T> for Law<T> {
    fn new(values: &[T]) -> Self {
        let [droop] = take(values);
        Self { droop }
    }

    fn drive(&self, command: T, largest: f64) -> T {
        command * (-(self.droop * magnitude(command) / largest) + 1.0)
    }

    fn response(&self, at: &JointSample<T>, largest: f64) -> Option<T> {
        // The effort after the droop is close to the command: droops are small.
        let command = at.drive.map_or_else(T::zero, magnitude);
        Some(-(self.droop * command * 2.0 / largest) + 1.0)
    }
}
