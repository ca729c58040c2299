//! The gripper: grasps the object at a point and drives it by force, or by velocity through a
//! compliant coupling.

use std::f64::consts::TAU;

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};
use trundle_model::{Rigid, State, to_body, to_world, transport};

use crate::SimError;

/// A spring and a damper between gripper and object.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Coupling {
    /// N/m, alike in all directions.
    pub stiffness: f64,
    /// N·s/m.
    pub damping: f64,
    /// N·m/rad.
    pub twist_stiffness: f64,
    /// N·m·s/rad.
    pub twist_damping: f64,
}

impl Default for Coupling {
    /// A rubber-padded parallel gripper: 5 mm of give at 50 N.
    fn default() -> Self {
        Self { stiffness: 1e4, damping: 400.0, twist_stiffness: 300.0, twist_damping: 30.0 }
    }
}

impl Coupling {
    /// Refuse what would not hold together.
    ///
    /// # Errors
    /// When a constant is negative or not finite.
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

/// What the gripper's command means.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Drive {
    /// The wrench on the object at the grasp, gripper axes, `[N, N, N·m]`.
    Force,
    /// The gripper's velocity, world axes, `[m/s, m/s, rad/s]`; the coupling makes it a wrench.
    Velocity,
    /// The velocity of a tip that does not hold the object but pushes its rim, world axes, `[m/s, m/s, –]`.
    Tip,
}

/// A gripper that has grasped the object.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Gripper {
    /// Where it holds the object: pose in the object frame, m and rad.
    grasp: [f64; 3],
    /// Its own pose in the world.
    pose: [f64; 3],
    drive: Drive,
    coupling: Coupling,
    /// What the arm can do at most, object axes; beyond that it stalls.
    most: Option<[f64; 3]>,
}

impl Gripper {
    /// Closed on an object at `object` (world), at `grasp` (object frame).
    pub fn new(grasp: [f64; 3], object: [f64; 3], drive: Drive, coupling: Coupling) -> Self {
        Self { grasp, pose: compose(object, grasp), drive, coupling, most: None }
    }

    /// The same on an arm that stalls at this wrench of its coupling, object axes about the grasp.
    #[must_use]
    pub fn at_most(self, most: [f64; 3]) -> Self {
        Self { most: Some(most), ..self }
    }

    /// Pose of the gripper and sensor frame in the world, while the object is at `object`.
    pub fn pose(&self, object: [f64; 3]) -> [f64; 3] {
        match self.drive {
            Drive::Force => compose(object, self.grasp),
            _ => self.pose,
        }
    }

    /// The mean wrench on the object over the coming step, object axes about the object origin; a
    /// velocity-driven gripper moves on.
    pub fn push(&mut self, command: [f64; 3], state: &State<f64>, rigid: &Rigid<f64>, dt: f64) -> [f64; 3] {
        match self.drive {
            Drive::Force => transport(command, self.grasp),
            _ => {
                let mut wrench = self.couple(command, state, rigid, dt);
                for (pose, velocity) in self.pose.iter_mut().zip(command) {
                    *pose += velocity * dt;
                }
                if let Some(most) = self.most {
                    wrench = [0, 1, 2].map(|k| wrench[k].clamp(-most[k], most[k]));
                    self.stall(most, state.pose);
                }
                transport(wrench, [self.grasp[0], self.grasp[1], 0.0])
            }
        }
    }

    /// The coupling's wrench about the grasp point, object axes: spring and damper at the end of the
    /// step (implicit, so that a stiff gripper on a light object is stable),
    ///
    /// ```text
    /// (I + dt B W) F = K e + B ė,   B = C + dt K,   W = J M⁻¹ Jᵀ at the grasp
    /// ```
    fn couple(&self, command: [f64; 3], state: &State<f64>, rigid: &Rigid<f64>, dt: f64) -> [f64; 3] {
        let c = &self.coupling;
        let stiffness = Vector3::new(c.stiffness, c.stiffness, c.twist_stiffness);
        let damping = Vector3::new(c.damping, c.damping, c.twist_damping) + stiffness * dt;
        let lag = self.stretch(state.pose);
        let rate = Vector3::from(to_body(command, state.pose[2])) - self.grasp_velocity(state);
        let force = stiffness.component_mul(&lag) + damping.component_mul(&rate);
        let system = Matrix3::identity() + Matrix3::from_diagonal(&(damping * dt)) * self.mobility(rigid);
        // A product of two positive semidefinite matrices has no negative eigenvalue: never singular.
        system.lu().solve(&force).unwrap_or(force).into()
    }

    /// Be no farther from the grasp point than the coupling's springs stretch at `most`.
    fn stall(&mut self, most: [f64; 3], object: [f64; 3]) {
        let c = &self.coupling;
        let give = [most[0] / c.stiffness, most[1] / c.stiffness, most[2] / c.twist_stiffness];
        let stretch = self.stretch(object);
        let kept = [0, 1, 2].map(|k| stretch[k].clamp(-give[k], give[k]));
        if kept != [stretch[0], stretch[1], stretch[2]] {
            let held = compose(object, self.grasp);
            let [x, y, turn] = to_world(kept, object[2]);
            self.pose = [held[0] + x, held[1] + y, held[2] + turn];
        }
    }

    /// Gripper less grasp point, object axes.
    fn stretch(&self, object: [f64; 3]) -> Vector3<f64> {
        let held = compose(object, self.grasp);
        let world = [0, 1].map(|k| self.pose[k] - held[k]);
        Vector3::from(to_body([world[0], world[1], wrap(self.pose[2] - held[2])], object[2]))
    }

    fn grasp_velocity(&self, state: &State<f64>) -> Vector3<f64> {
        let [vx, vy, spin] = to_body(state.twist, state.pose[2]);
        Vector3::new(vx - spin * self.grasp[1], vy + spin * self.grasp[0], spin)
    }

    /// Acceleration of the grasp per unit of wrench on it, object axes.
    fn mobility(&self, rigid: &Rigid<f64>) -> Matrix3<f64> {
        let (m, i) = (rigid.mass.recip(), rigid.inertia.recip());
        let (x, y) = (self.grasp[0] - rigid.com[0], self.grasp[1] - rigid.com[1]);
        Matrix3::new(m + y * y * i, -x * y * i, -y * i, -x * y * i, m + x * x * i, x * i, -y * i, x * i, i)
    }
}

/// The pose `inner`, given in the frame `outer`, in the frame that `outer` is given in.
pub(crate) fn compose(outer: [f64; 3], inner: [f64; 3]) -> [f64; 3] {
    let (sin, cos) = outer[2].sin_cos();
    [
        outer[0] + cos * inner[0] - sin * inner[1],
        outer[1] + sin * inner[0] + cos * inner[1],
        outer[2] + inner[2],
    ]
}

/// The pose `inner` as seen from the frame `outer`, both given in the world.
pub(crate) fn relative(outer: [f64; 3], inner: [f64; 3]) -> [f64; 3] {
    let difference = [inner[0] - outer[0], inner[1] - outer[1], wrap(inner[2] - outer[2])];
    to_body(difference, outer[2])
}

/// An angle in (−π, π].
pub(crate) fn wrap(angle: f64) -> f64 {
    angle - TAU * (angle / TAU - 0.5).ceil()
}
