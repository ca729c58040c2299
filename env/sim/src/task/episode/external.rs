//! Motion that another simulator computes.

use trundle_model::State;

use super::{Episode, StepSums};
use crate::SimError;
use crate::task::action_mode::ActionMode;
use crate::task::external_step::ExternalStep;
use crate::task::outcome::Outcome;

impl Episode {
    /// Advance by one action along a motion that another simulator computed.
    ///
    /// # Errors
    /// If the options do not allow it, the number of steps is not that of an action, or a value is not finite. The
    /// episode is then unchanged.
    pub fn follow(&mut self, motion: &[ExternalStep]) -> Result<Outcome, SimError> {
        self.require_external_motion(motion)?;
        let dt = self.options.step;
        let mut sums = StepSums::default();
        for step in motion {
            let clock = self.clock(f64::from(self.state.tick) * dt);
            let poses = self.poses();
            let inner = self.stepper.state().inner;
            self.stepper.set_state(State { pose: step.pose, twist: step.twist, inner });
            self.read_instruments(&poses, [step.wrench; 2], false, clock);
            self.end_tick(step.wrench, (step.impulse > 0.0).then_some(step.impulse), &mut sums);
        }
        self.state.steps += 1;
        let outcome = self.outcome(&sums, 1);
        self.state.ended = outcome.terminated || outcome.truncated;
        Ok(outcome)
    }

    fn require_external_motion(&self, motion: &[ExternalStep]) -> Result<(), SimError> {
        let refuse = |name, value: String, remedy| Err(SimError::value(name, value, remedy));
        let options = &self.options;
        if options.action != ActionMode::Wrench {
            return refuse(
                "action",
                format!("{:?}", options.action),
                "another simulator requires \"wrench\"",
            );
        }
        if !options.arm.is_ideal() || options.decision_time > 0.0 || options.measures_decisions {
            let remedy = "the other simulator contains the arm: remove arm and realtime";
            return refuse("arm", "not ideal".into(), remedy);
        }
        let steps = options.substeps_per_action() as usize;
        if motion.len() != steps {
            let remedy = "give one for each simulation step of an action: the option substeps";
            return refuse("number of steps", format!("{} instead of {steps}", motion.len()), remedy);
        }
        match motion.iter().position(|step| !step.is_finite()) {
            Some(row) => refuse("motion", format!("not finite in step {row}"), "check the other simulator"),
            None => Ok(()),
        }
    }
}
