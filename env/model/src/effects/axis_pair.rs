//! Dry friction along two perpendicular axes and about the vertical, shared by the laws of guides and joints.

use super::{angle, positive};
use crate::Real;
use crate::generalised_force::GeneralisedForce;
use crate::law::Param;
use std::f64::consts::PI;

/// Direction of the first axis, rad.
pub(super) const fn direction(help: &'static str) -> Param {
    angle("angle", PI, help)
}

/// Sliding friction along the first axis, N.
pub(super) const fn force_x() -> Param {
    positive("force_x", "N", 1e5, (10.0, 1.5), "sliding friction along the first axis").alternative()
}

/// Sliding friction along the second axis, N.
pub(super) const fn force_y() -> Param {
    positive("force_y", "N", 1e5, (10.0, 1.5), "sliding friction along the second axis")
        .alternative()
        .planar()
}

/// Friction torque about the vertical, N·m.
pub(super) const fn torque() -> Param {
    positive("torque", "N·m", 1e5, (2.0, 1.5), "friction torque about the vertical").alternative().planar()
}

/// Friction of each axis, smoothed at rest.
#[derive(Clone, Debug)]
pub(super) struct AxisPair<T> {
    force: [T; 2],
    torque: T,
    /// Speed below which friction is proportional to the speed, m/s.
    creep: T,
    /// The same for rotation, rad/s.
    creep_spin: T,
}

impl<T: Real> AxisPair<T> {
    /// Create the pair. For rotation, the creep speed applies at the radius of gyration, m.
    pub fn new(force: [T; 2], torque: T, creep: T, gyration: f64) -> Self {
        let creep_spin = if gyration > 0.0 { creep / gyration } else { creep };
        Self { force, torque, creep, creep_spin }
    }

    /// Add `F_k = −f_k (v·n_k)/√((v·n_k)² + ε²)` along the axes and `τ = −T ω/√(ω² + ε_ω²)`; the first axis is
    /// `n = [n_x, n_y]` in object axes.
    #[inline]
    pub fn add_friction(&self, [nx, ny]: [T; 2], [vx, vy, spin]: [T; 3], sum: &mut GeneralisedForce<T>) {
        for (force, [nx, ny]) in self.force.into_iter().zip([[nx, ny], [-ny, nx]]) {
            let along = vx * nx + vy * ny;
            let c = force / (along.squared() + self.creep.squared()).sqrt();
            sum.damping[0] += c * nx * nx;
            sum.damping[1] += c * nx * ny;
            sum.damping[2] += c * ny * ny;
        }
        sum.damping[5] += self.torque / (spin.squared() + self.creep_spin.squared()).sqrt();
    }
}
