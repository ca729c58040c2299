//! Measurements of an episode.

use super::Episode;
use crate::task::action_mode::ActionMode;
use crate::task::measurement_delay::Measurement;

impl Episode {
    /// The present measurement.
    pub(super) fn measurement(&self) -> Measurement {
        let state = self.stepper.state();
        let pose = state.pose;
        let [x, y, _] = self.state.action_model.grasp;
        let pose = self.instrumented.as_ref().map_or(pose, |plant| self.tracker.tracked_pose(pose, plant));
        Measurement { pose, twist: state.twist, wrench: self.state.wrist_wrench, grasp: [x, y] }
    }

    /// The measurement that is observed now.
    pub(super) fn observed_measurement(&self) -> Measurement {
        let delayed = self.state.delayed.as_ref().and_then(|delayed| delayed.observed(self.state.tick));
        let now = self.measurement();
        match delayed {
            // The mean over a push is known only after it.
            Some(delayed) if self.options.action == ActionMode::Push => {
                Measurement { wrench: now.wrench, ..delayed }
            }
            Some(delayed) => delayed,
            None => now,
        }
    }

    /// Whether the measurement after `tick` simulation steps will be observed later.
    pub(super) fn measures_after(&self, tick: u32) -> bool {
        self.state.delayed.as_ref().is_some_and(|delayed| delayed.is_observed(tick))
    }

    /// Store the present measurement if it will be observed later.
    pub(super) fn store_measurement(&mut self) {
        if self.measures_after(self.state.tick) {
            let now = self.measurement();
            self.state.delayed.iter_mut().for_each(|delayed| delayed.push(now));
        }
    }
}
