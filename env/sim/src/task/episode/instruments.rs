//! Readings of the wrist sensor, and what a recorder observes.

use trundle_model::{Clock, to_body};

use super::Episode;
use crate::Sensor;
use crate::instruments::GroundTruth;
use crate::sensor::{GripperLoad, reading_delay, wrench_in_frame};

/// Poses of object and gripper at one time.
pub(super) struct Poses {
    pub object: [f64; 3],
    pub gripper: [f64; 3],
    /// Pose of the gripper in the object frame.
    pub frame: [f64; 3],
}

impl Episode {
    /// Record the pre-contact interval.
    pub(super) fn wait_for_contact(&mut self) {
        let dt = self.options.step;
        for tick in 0..(self.sensor.precontact / dt).round() as u32 {
            if self.recorder.is_none() {
                return;
            }
            let clock = self.clock(f64::from(tick) * dt - self.sensor.precontact);
            let poses = self.poses();
            self.record([0.0; 3], &poses, [0.0; 2], clock);
        }
    }

    pub(super) fn clock(&self, since_contact: f64) -> Clock {
        let dt = self.options.step;
        let [x, y, _] = self.state.action_model.grasp;
        Clock { t: since_contact + dt / 2.0, dt, grasp: [x, y], ..Clock::since_contact(since_contact) }
    }

    /// Current poses of object and gripper.
    pub(super) fn poses(&self) -> Poses {
        let object = self.stepper.state().pose;
        Poses {
            object,
            gripper: self.state.action_model.pose(object),
            frame: self.state.action_model.frame(object),
        }
    }

    /// Record and read the wrist sensor after the step from `poses`: the recorded wrench and the mean one on the object.
    pub(super) fn read_instruments(
        &mut self,
        poses: &Poses,
        [recorded, mean]: [[f64; 3]; 2],
        is_discontinuous: bool,
        clock: Clock,
    ) {
        let accel = self.gripper_acceleration(poses, is_discontinuous);
        self.record(recorded, poses, accel, clock);
        self.state.wrist_wrench = self.wrist_reading(mean, poses, accel, clock);
    }

    /// Acceleration of the gripper in the step from `poses`, world axes, m/s².
    pub(super) fn gripper_acceleration(&mut self, poses: &Poses, is_discontinuous: bool) -> [f64; 2] {
        let dt = self.options.step;
        let next = self.state.action_model.pose(self.stepper.state().pose);
        let velocity = [0, 1].map(|k| (next[k] - poses.gripper[k]) / dt);
        let last_velocity = if is_discontinuous { velocity } else { self.state.gripper_velocity };
        self.state.gripper_velocity = velocity;
        [0, 1].map(|k| (velocity[k] - last_velocity[k]) / dt)
    }

    /// Reading of the wrist sensor for a wrench on the object, with instrument effects and delay.
    pub(super) fn wrist_reading(
        &mut self,
        wrench: [f64; 3],
        poses: &Poses,
        accel: [f64; 2],
        clock: Clock,
    ) -> [f64; 3] {
        let Some(plant) = &self.instrumented else { return wrench_in_frame(wrench, poses.frame) };
        let [ax, ay, _] = to_body([accel[0], accel[1], 0.0], poses.gripper[2]);
        let load = GripperLoad { wrench, frame: poses.frame, accel: [ax, ay] };
        let sensor = Sensor { offset: [0.0; 3], ..self.sensor };
        let read = sensor.reading(&load, plant, clock);
        let delay_steps = (reading_delay(plant, clock).max(0.0) / self.options.step).round() as usize;
        self.state.delayed_readings.push_back(read);
        while self.state.delayed_readings.len() > delay_steps + 1 {
            self.state.delayed_readings.pop_front();
        }
        self.state.delayed_readings.front().copied().unwrap_or(read)
    }

    pub(super) fn record(&mut self, wrench: [f64; 3], poses: &Poses, accel: [f64; 2], clock: Clock) {
        let Some(recorder) = &mut self.recorder else { return };
        let plant = self.instrumented.as_deref().unwrap_or(self.stepper.plant());
        recorder.observe(&GroundTruth {
            t: self.sensor.precontact + clock.since_contact,
            object: poses.object,
            gripper: poses.gripper,
            wrench,
            accel,
            plant,
            clock,
        });
    }
}
