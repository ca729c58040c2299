//! Friction curve of the dry friction laws: Coulomb friction with the Stribeck effect, smooth at rest.

use super::positive;
use crate::Real;
use crate::law::{Param, Role};

/// Default creep speed, below which dry friction is proportional to the speed, m/s. A load of half the friction force
/// creeps at about half of it: 0.25 mm in 5 s.
const DEFAULT_CREEP_M_PER_S: f64 = 1e-4;

/// Breakaway friction, N.
pub(crate) const fn static_force() -> Param {
    let help = "breakaway friction; without effect if at or below `force`";
    positive("static_force", "N", 1e5, (15.0, 1.5), help).refinement(0.0)
}

/// Stribeck velocity, m/s.
pub(crate) const fn stribeck_velocity() -> Param {
    let help = "speed over which friction decays from breakaway to sliding";
    positive("stribeck_velocity", "m/s", 10.0, (0.01, 1.0), help).role(Role::Shape).refinement(0.01)
}

/// Creep speed, m/s. Rubber and felt creep under load, as do the contacts of most simulators, at 0.1 to 10 mm/s.
pub(crate) const fn creep() -> Param {
    let help = "speed below which friction is proportional to the speed (creep instead of stiction)";
    let creep =
        positive("creep", "m/s", 1.0, (1e-3, 1.5), help).role(Role::Shape).refinement(DEFAULT_CREEP_M_PER_S);
    Param { lower: 1e-6, ..creep }
}

/// Dry friction of one contact.
#[derive(Clone, Debug)]
pub(crate) struct DryFriction<T> {
    /// Sliding friction, N.
    pub force: T,
    /// Breakaway friction, N; without effect if below `force`.
    pub static_force: T,
    /// Stribeck velocity, m/s.
    pub stribeck: T,
    /// Creep speed, below which friction is proportional to the speed, m/s.
    pub creep: T,
}

impl<T: Real> DryFriction<T> {
    /// Whether the friction does not depend on the speed.
    pub fn is_constant(&self) -> bool {
        self.static_force.re() <= self.force.re()
    }

    /// Coefficient `c` of `F = −c·v` at a velocity, N·s/m: `f(|v|) / √(|v|² + ε²)` with the Stribeck curve
    /// `f = F_c + (F_s − F_c) exp(−|v|²/v_s²)` (Armstrong-Hélouvry et al. 1994, eq. 5).
    #[inline]
    pub fn coefficient(&self, [vx, vy]: [T; 2]) -> T {
        let square = vx.squared() + vy.squared();
        let speed = (square + self.creep.squared()).sqrt();
        if self.is_constant() {
            return self.force / speed;
        }
        let fade = (-(square / self.stribeck.squared())).exp();
        (self.force + (self.static_force - self.force) * fade) / speed
    }
}
