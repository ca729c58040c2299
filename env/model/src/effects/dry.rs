//! The dry friction curve that every dry law shares: Coulomb with Stribeck's excess, smooth at rest.

use crate::Real;

/// Speed below which dry friction turns into creep, m/s. At full stick a load of half the
/// friction force creeps at about half of this: 0.25 mm in 5 s.
const CREEP: f64 = 1e-4;

/// Dry friction of one contact.
#[derive(Clone, Debug)]
pub(crate) struct Dry<T> {
    /// Sliding friction, N.
    pub force: T,
    /// Friction at breakaway, N; below `force` it has no effect.
    pub static_force: T,
    /// Speed over which breakaway friction fades, m/s.
    pub stribeck: T,
}

impl<T: Real> Dry<T> {
    /// The coefficient `c` of `F = −c·v` at a velocity, N·s/m: `f(|v|) / √(|v|² + ε²)` with
    /// Stribeck's `f = F_c + (F_s − F_c) exp(−|v|²/v_s²)` (Armstrong-Hélouvry et al. 1994, eq. 5).
    #[inline]
    pub fn coefficient(&self, [vx, vy]: [T; 2]) -> T {
        let square = vx.squared() + vy.squared();
        let speed = (square + CREEP * CREEP).sqrt();
        if self.static_force.re() <= self.force.re() {
            return self.force / speed;
        }
        let fade = (-(square / self.stribeck.squared())).exp();
        (self.force + (self.static_force - self.force) * fade) / speed
    }
}
