//! The gripper: holds the object at a grasp and drives it by force, or by velocity through a compliant coupling.

use std::f64::consts::TAU;

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};
use trundle_model::{Rigid, State, to_body, to_world, transport};

use crate::SimError;

/// Spring and damper between gripper and object.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Coupling {
    /// Translational stiffness, isotropic, N/m.
    pub stiffness: f64,
    /// Translational damping, N·s/m.
    pub damping: f64,
    /// Rotational stiffness, N·m/rad.
    pub twist_stiffness: f64,
    /// Rotational damping, N·m·s/rad.
    pub twist_damping: f64,
}

impl Default for Coupling {
    /// A rubber-padded parallel gripper that yields 5 mm at 50 N.
    fn default() -> Self {
        Self { stiffness: 1e4, damping: 400.0, twist_stiffness: 300.0, twist_damping: 30.0 }
    }
}

impl Coupling {
    /// Check the values.
    ///
    /// # Errors
    /// If a constant is negative or not finite.
    pub fn check(&self) -> Result<(), SimError> {
        for (key, value) in [
            ("gripper.stiffness", self.stiffness),
            ("gripper.damping", self.damping),
            ("gripper.twist_stiffness", self.twist_stiffness),
            ("gripper.twist_damping", self.twist_damping),
        ] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(SimError::value(key, value, "must be finite and not negative"));
            }
        }
        Ok(())
    }
}

/// Meaning of the end effector's command.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DriveMode {
    /// Wrench on the object at the grasp, gripper axes, `[N, N, N·m]`.
    Force,
    /// Velocity of the gripper, world axes, `[m/s, m/s, rad/s]`. The coupling converts it to a wrench.
    Velocity,
    /// Velocity of a fingertip that pushes the rim without holding the object, world axes, `[m/s, m/s, –]`.
    #[serde(rename = "tip")]
    PointContact,
}

/// A gripper that holds the object.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Gripper {
    /// Pose of the gripper in the object frame, m and rad.
    grasp: [f64; 3],
    /// Pose of the gripper in the world.
    pose: [f64; 3],
    drive: DriveMode,
    coupling: Coupling,
    /// Largest wrench of the arm, object axes. The arm stalls beyond it.
    max_wrench: Option<[f64; 3]>,
    /// Mass in front of a soft wrist, which a commanded wrench accelerates. Without it the wrench acts on the object.
    hand: Option<Hand>,
}

/// Mass in front of a soft wrist.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hand {
    /// Mass, kg.
    pub mass: f64,
    /// Moment of inertia, kg·m².
    pub inertia: f64,
    /// Velocity and spin, world axes.
    pub twist: [f64; 3],
}

impl Hand {
    /// Acceleration per unit of wrench.
    fn mobility(&self) -> Vector3<f64> {
        Vector3::new(self.mass.recip(), self.mass.recip(), self.inertia.recip())
    }
}

impl Gripper {
    /// A gripper closed on an object at pose `object` (world), with pose `grasp` (object frame).
    pub fn new(grasp: [f64; 3], object: [f64; 3], drive: DriveMode, coupling: Coupling) -> Self {
        Self { grasp, pose: compose(object, grasp), drive, coupling, max_wrench: None, hand: None }
    }

    /// The same gripper on an arm that stalls at this coupling wrench, object axes about the grasp.
    #[must_use]
    pub fn with_max_wrench(self, max_wrench: [f64; 3]) -> Self {
        Self { max_wrench: Some(max_wrench), ..self }
    }

    /// The same gripper behind a soft wrist: the coupling is the wrist, and a commanded wrench acts on the hand.
    #[must_use]
    pub fn with_hand(self, hand: Hand) -> Self {
        Self { hand: Some(hand), ..self }
    }

    /// Hold an object at another grasp, without stretch and at its velocity.
    pub fn hold(&mut self, grasp: [f64; 3], state: &State<f64>) {
        (self.grasp, self.pose) = (grasp, compose(state.pose, grasp));
        let twist = to_world(self.grasp_velocity(state).into(), state.pose[2]);
        if let Some(hand) = &mut self.hand {
            hand.twist = twist;
        }
    }

    /// Pose of the gripper and sensor frame in the world, with the object at `object`.
    pub fn pose(&self, object: [f64; 3]) -> [f64; 3] {
        match self.drive {
            DriveMode::Force => compose(object, self.grasp),
            _ => self.pose,
        }
    }

    /// Advance the gripper by one step. Returns the mean wrench on the object over the step, object axes about the object
    /// origin.
    pub fn step(&mut self, command: [f64; 3], state: &State<f64>, rigid: &Rigid<f64>, dt: f64) -> [f64; 3] {
        match self.drive {
            DriveMode::Force => match self.hand {
                Some(hand) => self.step_hand(hand, command, state, rigid, dt),
                None => transport(command, self.grasp),
            },
            _ => {
                let velocity = Vector3::from(to_body(command, state.pose[2]));
                let mut wrench: [f64; 3] =
                    self.coupling_wrench(velocity, self.mobility(rigid), state, dt).into();
                for (pose, velocity) in self.pose.iter_mut().zip(command) {
                    *pose += velocity * dt;
                }
                if let Some(max_wrench) = self.max_wrench {
                    wrench = [0, 1, 2].map(|k| wrench[k].clamp(-max_wrench[k], max_wrench[k]));
                    self.limit_stretch(max_wrench, state.pose);
                }
                transport(wrench, [self.grasp[0], self.grasp[1], 0.0])
            }
        }
    }

    /// Advance the hand under a wrench in its axes. Returns the wrench on the object as [`Gripper::step`] does.
    fn step_hand(
        &mut self,
        hand: Hand,
        command: [f64; 3],
        state: &State<f64>,
        rigid: &Rigid<f64>,
        dt: f64,
    ) -> [f64; 3] {
        let (heading, mobility) = (state.pose[2], hand.mobility());
        let pushed = Vector3::from(to_world(command, self.pose[2] - heading));
        let free = Vector3::from(to_body(hand.twist, heading)) + mobility.component_mul(&pushed) * dt;
        let both = self.mobility(rigid) + Matrix3::from_diagonal(&mobility);
        let wrench = self.coupling_wrench(free, both, state, dt);
        let twist = to_world((free - mobility.component_mul(&wrench) * dt).into(), heading);
        self.hand = Some(Hand { twist, ..hand });
        for (pose, velocity) in self.pose.iter_mut().zip(twist) {
            *pose += velocity * dt;
        }
        transport(wrench.into(), [self.grasp[0], self.grasp[1], 0.0])
    }

    /// Wrench of the coupling about the grasp point, object axes, if the gripper has the velocity `velocity`, object axes.
    /// Spring and damper are evaluated at the end of the step (implicit, so that a stiff gripper on a light object is
    /// stable):
    ///
    /// ```text
    /// (I + dt B W) F = K e + B ė,   B = C + dt K,   W = J M⁻¹ Jᵀ at the grasp
    /// ```
    ///
    /// `mobility` is W, plus that of the hand if a wrench is commanded.
    fn coupling_wrench(
        &self,
        velocity: Vector3<f64>,
        mobility: Matrix3<f64>,
        state: &State<f64>,
        dt: f64,
    ) -> Vector3<f64> {
        let c = &self.coupling;
        let stiffness = Vector3::new(c.stiffness, c.stiffness, c.twist_stiffness);
        let damping = Vector3::new(c.damping, c.damping, c.twist_damping) + stiffness * dt;
        let lag = self.stretch(state.pose);
        let rate = velocity - self.grasp_velocity(state);
        let force = stiffness.component_mul(&lag) + damping.component_mul(&rate);
        let system = Matrix3::identity() + Matrix3::from_diagonal(&(damping * dt)) * mobility;
        // The product of two positive semidefinite matrices has no negative eigenvalue, so the system is never singular.
        system.lu().solve(&force).unwrap_or(force)
    }

    /// Limit the distance from the grasp point to the spring deflection at `max_wrench`.
    fn limit_stretch(&mut self, max_wrench: [f64; 3], object: [f64; 3]) {
        let c = &self.coupling;
        let max_stretch =
            [max_wrench[0] / c.stiffness, max_wrench[1] / c.stiffness, max_wrench[2] / c.twist_stiffness];
        let stretch = self.stretch(object);
        let limited = [0, 1, 2].map(|k| stretch[k].clamp(-max_stretch[k], max_stretch[k]));
        if limited != [stretch[0], stretch[1], stretch[2]] {
            let grasp_pose = compose(object, self.grasp);
            let [x, y, turn] = to_world(limited, object[2]);
            self.pose = [grasp_pose[0] + x, grasp_pose[1] + y, grasp_pose[2] + turn];
        }
    }

    /// Pose of the gripper minus the grasp pose, object axes.
    fn stretch(&self, object: [f64; 3]) -> Vector3<f64> {
        let grasp_pose = compose(object, self.grasp);
        let world = [0, 1].map(|k| self.pose[k] - grasp_pose[k]);
        Vector3::from(to_body([world[0], world[1], wrap_angle(self.pose[2] - grasp_pose[2])], object[2]))
    }

    fn grasp_velocity(&self, state: &State<f64>) -> Vector3<f64> {
        let [vx, vy, spin] = to_body(state.twist, state.pose[2]);
        Vector3::new(vx - spin * self.grasp[1], vy + spin * self.grasp[0], spin)
    }

    /// Acceleration of the grasp per unit of wrench at it, object axes.
    fn mobility(&self, rigid: &Rigid<f64>) -> Matrix3<f64> {
        let (m, i) = (rigid.mass.recip(), rigid.inertia.recip());
        let (x, y) = (self.grasp[0] - rigid.com[0], self.grasp[1] - rigid.com[1]);
        Matrix3::new(m + y * y * i, -x * y * i, -y * i, -x * y * i, m + x * x * i, x * i, -y * i, x * i, i)
    }
}

/// Composition of poses: `inner`, given in the frame `outer`, expressed in the parent frame of `outer`.
pub(crate) fn compose(outer: [f64; 3], inner: [f64; 3]) -> [f64; 3] {
    let (sin, cos) = outer[2].sin_cos();
    [
        outer[0] + cos * inner[0] - sin * inner[1],
        outer[1] + sin * inner[0] + cos * inner[1],
        outer[2] + inner[2],
    ]
}

/// Pose `inner` relative to the frame `outer`, both given in the world.
pub(crate) fn relative(outer: [f64; 3], inner: [f64; 3]) -> [f64; 3] {
    let difference = [inner[0] - outer[0], inner[1] - outer[1], wrap_angle(inner[2] - outer[2])];
    to_body(difference, outer[2])
}

/// The angle wrapped to (−π, π].
pub(crate) fn wrap_angle(angle: f64) -> f64 {
    angle - TAU * (angle / TAU - 0.5).ceil()
}
