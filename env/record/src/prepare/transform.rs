//! Transformation of wrenches between frames: equations 10, 11 and 13 of the paper.

use nalgebra::{Quaternion, Rotation3, UnitQuaternion, Vector3};

/// Forces x, y, z in N and torques x, y, z in N m.
pub type Wrench6 = [f64; 6];

/// Transforms `wrench` from frame B to frame A (equation 11).
///
/// `rotation` and `position` (m) give the pose of frame B in frame A.
pub fn force_moment_transform(
    rotation: &Rotation3<f64>,
    position: &Vector3<f64>,
    wrench: &Wrench6,
) -> Wrench6 {
    let (force, torque) = split(wrench);
    let force = rotation * force;
    join(&force, &(position.cross(&force) + rotation * torque))
}

/// Transforms the planar wrench `reading` = `[f_x, f_y, τ_z]` from a frame to its parent frame (equation 13 in the plane).
///
/// `frame` is the pose of the frame in the parent frame: x, y in m, angle in rad.
pub fn planar_transform(frame: &[f64; 3], reading: &[f64; 3]) -> [f64; 3] {
    let position = Vector3::new(frame[0], frame[1], 0.0);
    let rotation = Rotation3::from_axis_angle(&Vector3::z_axis(), frame[2]);
    let wrench = [reading[0], reading[1], 0.0, 0.0, 0.0, reading[2]];
    let moved = force_moment_transform(&rotation, &position, &wrench);
    [moved[0], moved[1], moved[5]]
}

/// Pose (x, y, angle) of frame B in frame A. `a` and `b` are their poses in the world.
pub fn relative_pose(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    let (sin, cos) = a[2].sin_cos();
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    [cos * dx + sin * dy, cos * dy - sin * dx, wrapped(b[2] - a[2])]
}

/// `angle` wrapped to (-π, π].
pub fn wrapped(angle: f64) -> f64 {
    let turn = std::f64::consts::TAU;
    let rest = angle.rem_euclid(turn);
    if rest > turn / 2.0 { rest - turn } else { rest }
}

/// Pose of the sensor frame in the world.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct GripperPose {
    pub t: f64,
    pub position: [f64; 2],
    pub attitude: UnitQuaternion<f64>,
}

impl GripperPose {
    pub fn level(t: f64, [x, y, theta]: [f64; 3]) -> Self {
        let attitude = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), theta);
        Self { t, position: [x, y], attitude }
    }

    pub fn tilting(t: f64, [x, y, _, w, i, j, k]: [f64; 7]) -> Self {
        let attitude = UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k));
        Self { t, position: [x, y], attitude }
    }

    /// Interpolated pose: linear in the position, spherical in the attitude.
    pub fn interpolate(&self, next: &Self, share: f64) -> Self {
        let along = |a: f64, b: f64| a + share * (b - a);
        Self {
            t: along(self.t, next.t),
            position: [0, 1].map(|k| along(self.position[k], next.position[k])),
            attitude: self.attitude.try_slerp(&next.attitude, share, 1e-9).unwrap_or(self.attitude),
        }
    }

    /// Rotation about the vertical, rad: the twist of the swing–twist decomposition.
    pub fn heading(&self) -> f64 {
        wrapped(2.0 * self.attitude.k.atan2(self.attitude.w))
    }

    /// Whether the sensor's z is exactly vertical.
    pub fn is_level(&self) -> bool {
        self.attitude.i == 0.0 && self.attitude.j == 0.0
    }

    /// x, y, heading in the world.
    pub fn planar(&self) -> [f64; 3] {
        [self.position[0], self.position[1], self.heading()]
    }

    /// The direction of gravity in the sensor frame.
    pub fn down(&self) -> Vector3<f64> {
        self.attitude.inverse_transform_vector(&-Vector3::z())
    }

    /// Planar projection of `wrench` (sensor axes): force along and across the heading, torque about the vertical through
    /// the sensor's origin.
    pub fn planar_wrench(&self, wrench: &Wrench6) -> [f64; 3] {
        let level = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -self.heading()) * self.attitude;
        let moved = force_moment_transform(&level.to_rotation_matrix(), &Vector3::zeros(), wrench);
        [moved[0], moved[1], moved[5]]
    }
}

pub(crate) fn split(wrench: &Wrench6) -> (Vector3<f64>, Vector3<f64>) {
    let [fx, fy, fz, tx, ty, tz] = *wrench;
    (Vector3::new(fx, fy, fz), Vector3::new(tx, ty, tz))
}

pub(crate) fn join(force: &Vector3<f64>, torque: &Vector3<f64>) -> Wrench6 {
    [force.x, force.y, force.z, torque.x, torque.y, torque.z]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    fn close(a: &[f64], b: &[f64]) -> bool {
        a.len() == b.len() && a.iter().zip(b).all(|(x, y)| (x - y).abs() < 1e-12)
    }

    #[test]
    fn an_eccentric_force_has_a_torque() {
        // 10 N along the sensor's x, which points along the object's y, 0.5 m right of its origin.
        let moved = planar_transform(&[0.5, 0.0, FRAC_PI_2], &[10.0, 0.0, 1.0]);
        assert!(close(&moved, &[0.0, 10.0, 6.0]));
    }

    #[test]
    fn equation_11_matches_a_hand_calculation() {
        let rotation = Rotation3::from_axis_angle(&Vector3::x_axis(), FRAC_PI_2);
        let moved =
            force_moment_transform(&rotation, &Vector3::new(0.0, 0.0, 2.0), &[1.0, 0.0, 3.0, 0.0, 0.5, 0.0]);
        // R f = (1, -3, 0); P × R f = (6, 2, 0); R τ = (0, 0, 0.5)
        assert!(close(&moved, &[1.0, -3.0, 0.0, 6.0, 2.0, 0.5]));
    }

    #[test]
    fn relative_pose_inverts_the_object_pose() {
        let rel = relative_pose(&[1.0, 2.0, FRAC_PI_2], &[1.0, 3.0, -PI]);
        assert!(close(&rel, &[1.0, 0.0, FRAC_PI_2]));
    }

    #[test]
    fn a_tilted_sensor_is_projected_through_its_attitude() {
        // Pitched by 90° about y: the sensor's z points along the world's x.
        let half = (0.5_f64).sqrt();
        let pose = GripperPose::tilting(0.0, [0.0, 0.0, 0.0, half, 0.0, half, 0.0]);
        assert!(pose.heading().abs() < 1e-12);
        let planar = pose.planar_wrench(&[0.0, 2.0, 7.0, -0.4, 0.0, 9.0]);
        assert!(close(&planar, &[7.0, 2.0, 0.4]));
    }

    #[test]
    fn the_heading_of_a_level_gripper_is_its_angle() {
        for angle in [-3.0, -0.4, 0.0, 2.5, PI] {
            assert!((wrapped(GripperPose::level(0.0, [0.0, 0.0, angle]).heading() - angle)).abs() < 1e-12);
        }
    }
}
