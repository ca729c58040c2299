//! Transformations between the object frame and a tracked frame that is mounted elsewhere on the object.
//!
//! States, readings and mass properties refer to the tracked frame, laws to the object frame. With `(o, θ)` the pose of
//! the tracked frame in the object frame and `q = −Rᵀo` the object origin in the tracked frame,
//!
//! ```text
//! v_object = R (v + ω × q),    F = Rᵀ F_object,   τ = τ_object + q × F
//! ```

use crate::heading::Heading;
use crate::{GeneralisedForce, Real};

/// Mounting pose of the tracked frame in the object frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mount<T> {
    angle: T,
    sin: T,
    cos: T,
    /// Object origin in the tracked frame, m.
    origin: [T; 2],
}

impl<T: Real> Mount<T> {
    /// Mount at `[x, y, angle]` in the object frame, m, m, rad.
    pub fn at([x, y, angle]: [T; 3]) -> Self {
        let (sin, cos) = angle.sin_cos();
        let origin = [-(cos * x + sin * y), sin * x - cos * y];
        Self { angle, sin, cos, origin }
    }

    /// Transform a point from the object frame to the tracked frame, m.
    pub fn transform_point(&self, point: [T; 2]) -> [T; 2] {
        let [x, y] = self.to_tracked_axes(point);
        [x + self.origin[0], y + self.origin[1]]
    }

    /// Pose of the object, given the tracked pose.
    pub fn pose(&self, [x, y, heading]: [T; 3]) -> [T; 3] {
        let [qx, qy] = self.origin;
        let [dx, dy, _] = Heading::of(heading).to_world([qx, qy, T::zero()]);
        [x + dx, y + dy, heading - self.angle]
    }

    /// Twist of the object in object axes, given the twist of the tracked frame in tracked axes.
    pub fn twist(&self, [vx, vy, spin]: [T; 3]) -> [T; 3] {
        let [qx, qy] = self.origin;
        let (vx, vy) = (vx - spin * qy, vy + spin * qx);
        [self.cos * vx - self.sin * vy, self.sin * vx + self.cos * vy, spin]
    }

    /// Transform a generalised force from the object frame to the tracked frame, each about its own origin.
    pub fn transform(
        &self,
        GeneralisedForce { force: [fx, fy, torque], damping: [xx, xy, yy, tx, ty, tt] }: &GeneralisedForce<T>,
    ) -> GeneralisedForce<T> {
        let mut moved = GeneralisedForce::zero();
        moved.force[2] = *torque;
        moved.add_force_at(self.origin, self.to_tracked_axes([*fx, *fy]));
        let (s, c) = (self.sin, self.cos);
        let (ss, cc, sc) = (s.squared(), c.squared(), s * c);
        let mixed = (*xx - *yy) * sc;
        let turned = [
            *xx * cc + *yy * ss + *xy * sc * 2.0,
            *xy * (cc - ss) - mixed,
            *xx * ss + *yy * cc - *xy * sc * 2.0,
        ];
        moved.add_damping_at(self.origin, turned);
        // Coupling of rotation and translation: a force per spin at the object origin and its torque.
        let ([ax, ay], [qx, qy]) = (self.to_tracked_axes([*tx, *ty]), self.origin);
        moved.damping[3] += ax;
        moved.damping[4] += ay;
        moved.damping[5] += *tt + (ay * qx - ax * qy) * 2.0;
        moved
    }

    /// Rotate a vector from object axes to tracked axes.
    fn to_tracked_axes(self, [x, y]: [T; 2]) -> [T; 2] {
        [self.cos * x + self.sin * y, self.cos * y - self.sin * x]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_power_is_the_same_in_both_frames() {
        let mount = Mount::at([0.3, -0.2, 0.7]);
        let force =
            GeneralisedForce { force: [3.0, -8.0, 2.0], damping: [40.0, 9.0, 120.0, -6.0, 11.0, 30.0] };
        for twist in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.3, -0.4, 0.8], [0.0, 0.0, -1.5]] {
            let power = |wrench: [f64; 3], twist: [f64; 3]| (0..3).map(|k| wrench[k] * twist[k]).sum::<f64>();
            let own = mount.twist(twist);
            let (there, here) =
                (power(force.wrench(own), own), power(mount.transform(&force).wrench(twist), twist));
            assert!((there - here).abs() < 1e-12 * there.abs().max(1.0), "{there} W is not {here} W");
        }
    }

    #[test]
    fn points_and_poses_agree() {
        let (mount, pose) = (Mount::at([0.3, -0.2, 0.7]), [1.0, 2.0, -0.4]);
        let own = mount.pose(pose);
        for point in [[0.0, 0.0], [0.5, 0.2]] {
            let world = |[x, y, heading]: [f64; 3], [px, py]: [f64; 2]| {
                let (sin, cos) = heading.sin_cos();
                [x + cos * px - sin * py, y + sin * px + cos * py]
            };
            let (a, b) = (world(own, point), world(pose, mount.transform_point(point)));
            assert!((a[0] - b[0]).hypot(a[1] - b[1]) < 1e-14, "{a:?} is not {b:?}");
        }
    }
}
