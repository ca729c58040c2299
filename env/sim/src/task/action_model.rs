//! Action model: converts actions to wrenches on the object.

use serde::{Deserialize, Serialize};
use trundle_model::{Body, Rigid, State, transport};

use super::action_mode::ActionMode;
use super::arm::Actuator;
use super::constants::*;
use super::options::Options;
use super::task_objects::TaskObject;
use crate::end_effector::EndEffector;
use crate::gripper::{compose, relative};
use crate::point_contact::{PointContact, TIP_RADIUS_M};
use crate::{Coupling, DriveMode, Gripper};

/// State of the arm and its current command.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ActionModel {
    /// Pose of the gripper or fingertip in the object frame, m and rad.
    pub grasp: [f64; 3],
    /// Whether the commands are wrenches.
    commands_wrench: bool,
    /// Simulated end effector; `None` if the commands are wrenches on the object.
    end_effector: Option<EndEffector>,
    /// Rate limit and lag of the arm, if it has any.
    actuator: Option<Actuator>,
    /// Start of the ramp to the current command. Wrenches on the object are in object axes about the object origin, or in
    /// gripper axes if there is an actuator.
    from: [f64; 3],
    /// Current command, in the same axes.
    to: [f64; 3],
    /// Simulation steps since the current command took effect.
    elapsed: u32,
    /// Simulation steps of a regrasp; `None` if the action mode has no regrasps.
    regrasp_steps: Option<u32>,
    /// Current regrasp, until the first command after its end.
    regrasp: Option<RegraspMotion>,
}

/// Motion of the gripper between two grasps at constant speed, object frame, m.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct RegraspMotion {
    from: [f64; 2],
    to: [f64; 2],
    /// Elapsed simulation steps.
    elapsed: u32,
    /// Total number of simulation steps.
    steps: u32,
}

impl RegraspMotion {
    /// Advance by one simulation step. Returns the new position.
    fn advance(&mut self) -> [f64; 2] {
        self.elapsed += 1;
        let share = f64::from(self.elapsed) / f64::from(self.steps);
        // This form is exact at the end.
        [0, 1].map(|k| (1.0 - share) * self.from[k] + share * self.to[k])
    }

    fn has_ended(&self) -> bool {
        self.elapsed >= self.steps
    }
}

impl ActionModel {
    /// The arm at a grasp, with the object at a pose.
    pub fn new(options: &Options, [x, y]: [f64; 2], object: [f64; 3]) -> Self {
        let grasp = [x, y, 0.0];
        let regrasp_steps = (options.action == ActionMode::Regrasp).then(|| options.regrasp_substeps());
        let wrist = options.arm.wrist;
        let end_effector = match options.action {
            ActionMode::Wrench | ActionMode::Regrasp => wrist.map(|wrist| {
                let gripper = Gripper::new(grasp, object, DriveMode::Force, wrist.coupling());
                EndEffector::Gripper(gripper.with_hand(wrist.hand()))
            }),
            ActionMode::Velocity => {
                let coupling = wrist.map_or_else(Coupling::default, |wrist| wrist.coupling());
                let gripper = Gripper::new(grasp, object, DriveMode::Velocity, coupling);
                Some(EndEffector::Gripper(gripper.with_max_wrench(FULL_WRENCH)))
            }
            ActionMode::Push => Some(EndEffector::withdrawn(grasp, object)),
        };
        Self {
            grasp,
            commands_wrench: matches!(options.action, ActionMode::Wrench | ActionMode::Regrasp),
            end_effector,
            actuator: Actuator::new(&options.arm, options.action),
            from: [0.0; 3],
            to: [0.0; 3],
            elapsed: 0,
            regrasp_steps,
            regrasp: None,
        }
    }

    /// Time since the current command took effect, s.
    pub fn elapsed(&self, dt: f64) -> f64 {
        f64::from(self.elapsed) * dt
    }

    /// Set a new command, in the units of [`ActionMode::full_scale`], after `period` and steps of `dt`, s. Returns whether
    /// the velocity of the gripper is discontinuous here, which must not count as an acceleration.
    pub fn set_command(
        &mut self,
        target: [f64; MAX_ACTION_WIDTH],
        [period, dt]: [f64; 2],
        task_object: &TaskObject,
        state: &State<f64>,
    ) -> bool {
        let object = state.pose;
        let [along, across, regrasp_request] = [3, 4, 5].map(|k| target[k]);
        let arrived = self.regrasp.take_if(|regrasp| regrasp.has_ended()).is_some();
        let departs = self.regrasp_steps.filter(|_| regrasp_request > 0.0 && self.regrasp.is_none());
        if let Some(steps) = departs {
            let [x, y, _] = self.grasp;
            self.regrasp = Some(RegraspMotion {
                from: [x, y],
                to: task_object.grasp_point([along, across]),
                elapsed: 0,
                steps,
            });
        }
        let elapsed = self.elapsed(dt);
        let reached = if elapsed < self.rise(period) { self.command_at(elapsed, period) } else { self.to };
        (self.from, self.to, self.elapsed) = (reached, [0, 1, 2].map(|k| target[k]), 0);
        if self.regrasp.is_some() {
            (self.from, self.to) = ([0.0; 3], [0.0; 3]);
            self.actuator.iter_mut().for_each(Actuator::rest);
        } else if self.end_effector.is_none() && self.actuator.is_none() {
            self.to = transport(self.to, self.grasp);
        }
        if let Some(EndEffector::Gripper(gripper)) = self.end_effector.as_mut().filter(|_| arrived) {
            gripper.hold(self.grasp, state);
        }
        if let Some(EndEffector::PointContact { contact, heading }) = &mut self.end_effector {
            let [place, lean, _] = self.to;
            let rim = task_object.rim_point(place);
            let (_, normal) = task_object.body.outside(outside_rim(rim, task_object.body.com));
            let angle = normal[1].atan2(normal[0]) + std::f64::consts::PI + lean;
            *contact = PointContact::at_rim(rim, normal, object);
            *heading = object[2] + angle;
            self.grasp = [rim[0], rim[1], angle];
            return true;
        }
        arrived || departs.is_some()
    }

    /// Advance by one step of `dt`, s. Actions are `period` apart, s. Returns the mean wrench on the object over the step,
    /// object axes about the object origin.
    pub fn step(
        &mut self,
        [period, dt]: [f64; 2],
        body: &Body,
        rigid: &Rigid<f64>,
        state: &State<f64>,
    ) -> [f64; 3] {
        let t = self.elapsed(dt);
        self.elapsed += 1;
        if let Some(regrasp) = &mut self.regrasp {
            [self.grasp[0], self.grasp[1]] = regrasp.advance();
            return [0.0; 3];
        }
        let mut command = self.command_at(t + dt / 2.0, period);
        if let Some(EndEffector::PointContact { contact, heading }) = &mut self.end_effector {
            contact.is_withdrawn = t >= PUSH_CONTACT_FRACTION * period;
            let speed = FULL_PUSH[2] + self.to[2];
            command = [speed * heading.cos(), speed * heading.sin(), 0.0];
        }
        if let Some(actuator) = &mut self.actuator {
            command = actuator.step(command, dt);
            if self.end_effector.is_none() {
                command = transport(command, self.grasp);
            }
        }
        let Some(end_effector) = &mut self.end_effector else { return command };
        end_effector.step(command, FULL_WRENCH[0], body, rigid, state, dt)
    }

    /// Present wrench, object axes about the object origin. `None` if the wrench is not commanded directly, or jumps because
    /// of a regrasp.
    pub fn instant_wrench(&self, [period, dt]: [f64; 2]) -> Option<[f64; 3]> {
        let is_direct = self.end_effector.is_none() && self.actuator.is_none() && self.regrasp.is_none();
        is_direct.then(|| self.command_at(self.elapsed(dt), period))
    }

    /// Pose of the gripper in the world.
    pub fn pose(&self, object: [f64; 3]) -> [f64; 3] {
        self.moving_end_effector()
            .map_or_else(|| compose(object, self.grasp), |end_effector| end_effector.pose(object))
    }

    /// Pose of the gripper in the object frame.
    pub fn frame(&self, object: [f64; 3]) -> [f64; 3] {
        self.moving_end_effector()
            .map_or(self.grasp, |end_effector| relative(object, end_effector.pose(object)))
    }

    /// The end effector if it moves against the object. Behind a soft wrist, the gripper holds the object rigidly.
    fn moving_end_effector(&self) -> Option<&EndEffector> {
        self.end_effector.as_ref().filter(|_| !self.commands_wrench)
    }

    /// Whether the gripper holds the object. It does not during a regrasp or in the action mode `push`.
    pub fn is_holding(&self) -> bool {
        !matches!(self.end_effector, Some(EndEffector::PointContact { .. }))
            && self.regrasp.as_ref().is_none_or(RegraspMotion::has_ended)
    }

    /// Time in which the command changes from one action to the next, s.
    fn rise(&self, period: f64) -> f64 {
        if self.commands_wrench { WRENCH_RISE_S.min(period) } else { period }
    }

    /// Command at a time. A wrench ramps quickly and is then constant. A velocity ramps during the whole period, which limits
    /// the acceleration.
    fn command_at(&self, t: f64, period: f64) -> [f64; 3] {
        let share = (t / self.rise(period)).min(1.0);
        [0, 1, 2].map(|k| self.from[k] + share * (self.to[k] - self.from[k]))
    }
}

/// A point slightly outside the rim, in the direction from the mass centre.
fn outside_rim(rim: [f64; 2], com: [f64; 2]) -> [f64; 2] {
    let (x, y) = (rim[0] - com[0], rim[1] - com[1]);
    let share = 1e-6f64.max(TIP_RADIUS_M * 1e-3) / x.hypot(y).max(1e-9);
    [rim[0] + x * share, rim[1] + y * share]
}
