//! An arm in motion: its state at the latest observation, and the commands that have not taken effect yet.

use trundle_model::{Clock, State, transport};

use super::response::{ArmResponse, AxisStates};
use crate::Dynamics;

/// Number of entries of [`CommandedArm::pending`] in one step of the prediction.
const SUBSTEPS_PER_STEP: usize = 10;

/// State of an arm at the latest observation. The default is an ideal arm.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CommandedArm {
    pub(super) response: ArmResponse,
    pub(super) states: AxisStates,
    /// Commands until the next one takes effect, in order, each `substep` long.
    pub(super) pending: Vec<[f64; 3]>,
    /// Duration of an entry of `pending`, s.
    pub(super) substep: f64,
}

impl CommandedArm {
    /// An arm without pending commands. `states` are those of its axes.
    #[cfg(test)]
    pub(crate) fn moving(response: ArmResponse, states: AxisStates) -> Self {
        Self { response, states, ..Self::default() }
    }

    /// Response of the arm.
    pub fn response(&self) -> &ArmResponse {
        &self.response
    }

    /// Advance the object from the latest observation until the next command takes effect. `grasp` is in the object frame,
    /// m. Returns the states of the axes.
    pub(crate) fn predict(
        &self,
        model: &impl Dynamics,
        grasp: [f64; 2],
        state: &mut State<f64>,
    ) -> AxisStates {
        let (mut states, mut clock) = (self.states, Clock::since_contact(0.0));
        if self.pending.is_empty() {
            return states;
        }
        let step = self.response.discretised(self.substep);
        for commands in self.pending.chunks(SUBSTEPS_PER_STEP) {
            let (count, mut sum) = (commands.len() as f64, [0.0; 3]);
            for command in commands {
                let mean = step.advance(&mut states, *command);
                sum = [0, 1, 2].map(|k| sum[k] + mean[k]);
            }
            let applied = transport(sum.map(|total| total / count), [grasp[0], grasp[1], 0.0]);
            model.step(state, &applied, clock, count * self.substep);
            clock.since_contact += count * self.substep;
        }
        states
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arm::AxisResponse;

    /// A mass of 1 kg and 1 kg·m² without friction.
    struct UnitMass;

    impl Dynamics for UnitMass {
        fn step(&self, state: &mut State<f64>, applied: &[f64; 3], _: Clock, dt: f64) {
            for (k, force) in applied.iter().enumerate() {
                state.pose[k] += dt * (state.twist[k] + dt * force / 2.0);
                state.twist[k] += dt * force;
            }
        }
    }

    #[test]
    fn pending_commands_move_the_object_before_a_plan_starts() {
        let arm =
            CommandedArm { pending: vec![[2.0, 0.0, 0.0]; 25], substep: 0.004, ..CommandedArm::default() };
        let mut state = State::at_rest([0.0; 3]);
        arm.predict(&UnitMass, [0.0; 2], &mut state);
        assert!((state.pose[0] - 0.01).abs() < 1e-12 && (state.twist[0] - 0.2).abs() < 1e-12, "{state:?}");
    }

    #[test]
    fn a_lag_reduces_the_impulse_and_remains_in_the_state() {
        let lag = AxisResponse::Lag { time_constant: 0.1 };
        let response = ArmResponse { delay: 0.1, force: lag, torque: lag, turn: 0.0 };
        let arm = CommandedArm {
            pending: vec![[2.0, 0.0, 0.0]; 20],
            substep: 0.005,
            ..CommandedArm::moving(response, AxisStates::default())
        };
        let mut state = State::at_rest([0.0; 3]);
        let states = arm.predict(&UnitMass, [0.0; 2], &mut state);
        // ∫ 2 (1 − e^(−t/0.1)) dt over 0.1 s.
        assert!((state.twist[0] - 0.2 * (-1.0f64).exp()).abs() < 1e-12, "{state:?}");
        assert!((states[0][0] - 2.0 * (1.0 - (-1.0f64).exp())).abs() < 1e-12, "{states:?}");
    }
}
