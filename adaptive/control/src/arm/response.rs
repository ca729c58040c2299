//! Response of an arm to commanded wrenches.

use super::axis::{AxisResponse, AxisStep};

/// Response of an arm: a delay, then a response along each axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ArmResponse {
    /// Time from an observation until the command that follows it shows in observations, s.
    pub delay: f64,
    /// Response of both components of the force.
    pub force: AxisResponse,
    /// Response of the torque.
    pub torque: AxisResponse,
    /// Turn of a compliant hand against the object per torque, rad/(N·m). The commanded force turns with the hand.
    pub turn: f64,
}

impl ArmResponse {
    /// Whether the wrench is the command at once.
    pub fn is_ideal(&self) -> bool {
        *self == Self::default()
    }

    /// Whether the wrench differs from the delayed command.
    pub(crate) fn has_dynamics(&self) -> bool {
        self.axes().iter().any(|axis| *axis != AxisResponse::Exact)
    }

    /// Responses of the three entries of a wrench.
    pub(crate) fn axes(&self) -> [AxisResponse; 3] {
        [self.force, self.force, self.torque]
    }

    /// The step of length `dt`, s, without the delay.
    pub(crate) fn discretised(&self, dt: f64) -> ArmStep {
        ArmStep { axes: self.axes().map(|axis| axis.discretised(dt)), turn: self.turn }
    }
}

/// States of the three axes.
pub(crate) type AxisStates = [[f64; 2]; 3];

/// Step of an arm.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ArmStep {
    axes: [AxisStep; 3],
    turn: f64,
}

impl ArmStep {
    /// Advance the states under a constant command. Returns the mean wrench over the step.
    #[inline]
    pub(crate) fn advance(&self, states: &mut AxisStates, command: [f64; 3]) -> [f64; 3] {
        let torque = self.axes[2].advance(&mut states[2], command[2]);
        let [x, y, _] = turned(command, self.turn * torque);
        [self.axes[0].advance(&mut states[0], x), self.axes[1].advance(&mut states[1], y), torque]
    }
}

/// A wrench with its force turned by an angle, rad.
#[inline]
pub(super) fn turned(wrench: [f64; 3], angle: f64) -> [f64; 3] {
    if angle == 0.0 {
        return wrench;
    }
    let (sin, cos) = angle.sin_cos();
    let [x, y, torque] = wrench;
    [cos * x - sin * y, sin * x + cos * y, torque]
}
