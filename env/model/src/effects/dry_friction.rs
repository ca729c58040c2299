//! The dry friction curve that every dry law shares: Coulomb with Stribeck's excess, smooth at rest.

use super::positive;
use crate::Real;
use crate::law::{Param, Role};

/// Speed below which dry friction turns into creep unless it is said, m/s. At full stick a load of half the
/// friction force creeps at about half of this: 0.25 mm in 5 s.
const DEFAULT_CREEP_M_PER_S: f64 = 1e-4;

/// Breakaway friction, N.
pub(crate) const fn static_force() -> Param {
    let help = "breakaway friction; at or below `force`: none in excess";
    positive("static_force", "N", 1e5, (15.0, 1.5), help).refinement(0.0)
}

/// Stribeck's speed, m/s.
pub(crate) const fn stribeck_velocity() -> Param {
    let help = "speed over which the breakaway friction fades";
    positive("stribeck_velocity", "m/s", 10.0, (0.01, 1.0), help).role(Role::Shape).refinement(0.01)
}

/// The speed of creep, m/s: rubber and felt creep under load, and so do the contacts of most simulators, which
/// give way at 0.1 to 10 mm/s.
pub(crate) const fn creep() -> Param {
    let help = "speed below which it gives way in proportion, rather than hold";
    let creep =
        positive("creep", "m/s", 1.0, (1e-3, 1.5), help).role(Role::Shape).refinement(DEFAULT_CREEP_M_PER_S);
    Param { lower: 1e-6, ..creep }
}

/// DryFriction friction of one contact.
#[derive(Clone, Debug)]
pub(crate) struct DryFriction<T> {
    /// Sliding friction, N.
    pub force: T,
    /// Friction at breakaway, N; below `force` it has no effect.
    pub static_force: T,
    /// Speed over which breakaway friction fades, m/s.
    pub stribeck: T,
    /// Speed below which it gives way in proportion, m/s.
    pub creep: T,
}

impl<T: Real> DryFriction<T> {
    /// The coefficient `c` of `F = −c·v` at a velocity, N·s/m: `f(|v|) / √(|v|² + ε²)` with
    /// Stribeck's `f = F_c + (F_s − F_c) exp(−|v|²/v_s²)` (Armstrong-Hélouvry et al. 1994, eq. 5).
    #[inline]
    pub fn coefficient(&self, [vx, vy]: [T; 2]) -> T {
        let square = vx.squared() + vy.squared();
        let speed = (square + self.creep.squared()).sqrt();
        if self.static_force.re() <= self.force.re() {
            return self.force / speed;
        }
        let fade = (-(square / self.stribeck.squared())).exp();
        (self.force + (self.static_force - self.force) * fade) / speed
    }
}
