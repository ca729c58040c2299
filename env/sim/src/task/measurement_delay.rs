//! Measurements of delayed sensors.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

use super::options::Options;

/// What the sensors measure at one time, without noise.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct Measurement {
    /// Pose of the object.
    pub pose: [f64; 3],
    /// Velocity and spin of the object.
    pub twist: [f64; 3],
    /// Wrench at the wrist, gripper axes.
    pub wrench: [f64; 3],
    /// Position of the grasp, object frame.
    pub grasp: [f64; 2],
}

/// Measurements that will be observed later, oldest first.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct MeasurementDelay {
    /// Delay, simulation steps.
    steps: u32,
    /// Simulation steps between two observations.
    interval: u32,
    pending: VecDeque<Measurement>,
}

impl MeasurementDelay {
    /// A delay of the options; `None` without a delay.
    pub fn new(options: &Options) -> Option<Self> {
        let (steps, interval) = (options.steps_in(options.sensor_delay), options.substeps_per_action());
        let capacity = (steps / interval) as usize + 3;
        (steps > 0).then(|| Self { steps, interval, pending: VecDeque::with_capacity(capacity) })
    }

    /// Whether the measurement at a simulation step will be observed.
    pub fn is_observed(&self, tick: u32) -> bool {
        tick == 0 || (tick + self.steps).is_multiple_of(self.interval)
    }

    /// Store a measurement. Only those that can still be observed are kept.
    pub fn push(&mut self, measurement: Measurement) {
        let most = (self.steps / self.interval) as usize + 1;
        while self.pending.len() > most {
            self.pending.pop_front();
        }
        self.pending.push_back(measurement);
    }

    /// The latest measurement that is at least as old as the delay at simulation step `now`; the first one before that.
    pub fn observed(&self, now: u32) -> Option<Measurement> {
        if now < self.steps {
            return self.pending.front().copied();
        }
        let newer = (self.steps / self.interval) as usize;
        self.pending.iter().nth_back(newer).copied()
    }
}
